"""A fake Universal Robots arm behind the three interfaces of ur-rtde, with the functions that the driver uses."""

import sys
from collections.abc import Sequence
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.data.cell_config import Cell
from robolaser.emulator.controller import Axis
from robolaser.emulator.faults import ARM, read_fault

COMMANDS = ("moveJ", "stopJ", "setStandardDigitalOut")
DEAF = ("silent", "cut", "lost", "late")


class UrRig:
    """The counterpart of `bench.Bench` for arms behind ur-rtde."""

    def __init__(self, cell: Cell, clock: Any, faults: Sequence[str] = ()) -> None:
        self.clock = clock
        self.controller = self
        self.sent = b""
        self._axes = [Axis(0.0) for _ in cell.robot.joints]
        self._faults = [read_fault(text) for text in faults]
        self._on: set[int] = set()
        self.open: set[str] = set()
        """Connected interfaces."""
        self.refuses: set[str] = set()
        """Interfaces that refuse to connect."""

    def motor(self, now_s: float | None = None) -> Array:
        self._strike()
        return np.array([axis.at(self.clock.now() if now_s is None else now_s) for axis in self._axes])

    def outputs(self, now_s: float) -> set[int]:
        return self._on

    def plugged_in(self, patch: pytest.MonkeyPatch) -> None:
        """Replace ur-rtde by this arm."""
        for name in ("control", "receive", "io"):
            module: Any = ModuleType(f"rtde_{name}")
            setattr(
                module, f"RTDE{'IO' if name == 'io' else name.title()}Interface", lambda _, end=name: self._end(end)
            )
            patch.setitem(sys.modules, f"rtde_{name}", module)

    def _end(self, name: str) -> "UrEnd":
        if name in self.refuses:
            raise RuntimeError("connection refused")
        self.open.add(name)
        return UrEnd(self, name)

    def getTimestamp(self) -> float:  # noqa: N802
        deaf = [fault for fault in self._faults if fault.kind in DEAF and fault.is_active(self.clock.now(), 0)]
        return min([self.clock.now(), *(fault.seconds[0] for fault in deaf)])

    def getActualQ(self) -> list[float]:  # noqa: N802
        self.clock.wait(0.002)
        return self.motor().tolist()

    def isProtectiveStopped(self) -> bool:  # noqa: N802
        return bool(self._struck())

    def isEmergencyStopped(self) -> bool:  # noqa: N802
        return False

    def getJointMode(self) -> list[int]:  # noqa: N802
        return [252 if i + 1 in self._struck() else 253 for i in range(len(self._axes))]

    def moveJ(self, q: list[float], speed: float, acceleration: float, asynchronous: bool) -> bool:  # noqa: N802
        """Move the leading axis at the speed, and all others in the same time."""
        assert asynchronous
        now = self.clock.now()
        way = max(abs(goal - axis.at(now)) for goal, axis in zip(q, self._axes, strict=True))
        for goal, axis in zip(q, self._axes, strict=True):
            axis.halt(now)
            axis.queue(goal, now, way / speed + speed / acceleration)
        return True

    def stopJ(self, deceleration: float, asynchronous: bool) -> None:  # noqa: N802
        for axis in self._axes:
            axis.halt(self.clock.now())

    def setStandardDigitalOut(self, output: int, on: bool) -> bool:  # noqa: N802
        (self._on.add if on else self._on.discard)(output + 1)
        return True

    def stopScript(self) -> None:  # noqa: N802
        """Nothing."""

    def _struck(self) -> set[int]:
        now = self.clock.now()
        return {int(f.amount) for f in self._faults if f.kind in ARM and f.is_active(now, 0)}

    def _strike(self) -> None:
        if self._struck():
            self.stopJ(0.0, asynchronous=True)


class UrEnd:
    """One of the three interfaces: without a connection, commands return False, and values are frozen."""

    def __init__(self, rig: UrRig, name: str) -> None:
        self._rig, self._name = rig, name

    def isConnected(self) -> bool:  # noqa: N802
        return self._name in self._rig.open

    def reconnect(self) -> bool:
        if self._name not in self._rig.refuses:
            self._rig.open.add(self._name)
        return self.isConnected()

    def disconnect(self) -> None:
        self._rig.open.discard(self._name)

    def __getattr__(self, name: str) -> Any:
        if name in COMMANDS and not self.isConnected():
            return lambda *_, **__: False
        return getattr(self._rig, name)
