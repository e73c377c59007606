"""An emulator in a process of its own, as people start it."""

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
    """An emulator in its own process, for as long as a `with` lasts.

    Attributes:
        arm: What pyserial opens to speak with the arm.
        camera: What OpenCV's VideoCapture opens; None without a world.
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
        self._asked = [str(cell), "--time-scale", str(time_scale), "--seed", str(seed)]
        self._asked += [word for fault in faults for word in ("--fault", fault)]
        self._asked += [] if world is None else ["--world", str(world)]
        self.arm = ""
        self.camera: str | None = None

    def __enter__(self) -> Self:
        """Start it and wait until it serves.

        Raises:
            ArmError: It said no, or nothing for two minutes.
        """
        self._process = subprocess.Popen(
            [sys.executable, "-m", "robolaser", "emulate", *self._asked],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        line = self._first_line()
        if not line:
            self._process.kill()
            said = self._process.communicate()[1].strip() or "nothing"
            raise ArmError(f"The emulator of {self._cell} did not start. It said: {said}")
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
        assert self._process.stdout is not None
        with selectors.DefaultSelector() as ready:
            ready.register(self._process.stdout, selectors.EVENT_READ)
            return self._process.stdout.readline() if ready.select(STARTING_S) else ""
