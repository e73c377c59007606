"""An emulator in a separate process, as users start it."""

import json
import selectors
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self, final

from robolaser.errors import ArmError

STARTING_S = 120.0
ENDING_S = 5.0


@final
class EmulatorProcess:
    """An emulator in a separate process, for the duration of a `with`.

    Attributes:
        arm: The arm's port, for pyserial.
        camera: The camera's address, for OpenCV's VideoCapture; None without a world.
    """

    def __init__(
        self,
        cell: Path,
        *,
        world: Path | None = None,
        time_scale: float = 1.0,
        faults: Sequence[str] = (),
        seed: int = 1,
    ) -> None:
        self._cell = cell
        self._arguments = [str(cell), "--time-scale", str(time_scale), "--seed", str(seed)]
        self._arguments += [word for fault in faults for word in ("--fault", fault)]
        self._arguments += [] if world is None else ["--world", str(world)]
        self.arm = ""
        self.camera: str | None = None

    def __enter__(self) -> Self:
        """Start it and wait until it serves.

        Raises:
            ArmError: It refused, or was silent for two minutes.
        """
        self._process = subprocess.Popen(
            [sys.executable, "-m", "robolaser", "emulate", *self._arguments], stdin=subprocess.PIPE,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        line = self._first_line()
        if not line:
            self._process.kill()
            errors = self._process.communicate()[1].strip() or "nothing"
            raise ArmError(f"The emulator of {self._cell} did not start. It said: {errors}")
        where = json.loads(line)
        self.arm, self.camera = where["arm"], where["camera"]
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End it."""
        with suppress(subprocess.TimeoutExpired):
            self._process.communicate(timeout=ENDING_S)
        self._process.kill()
        self._process.communicate()

    def _first_line(self) -> str:
        with selectors.DefaultSelector() as ready:
            ready.register(self._process.stdout, selectors.EVENT_READ)
            return self._process.stdout.readline() if ready.select(STARTING_S) else ""
