"""A recording in place of an arm: it jumps to the recorded poses."""

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell.arm import Arm
from robolaser.cell.clock import Clock
from robolaser.data.cell_config import FILE, Cell
from robolaser.data.loading import load
from robolaser.data.toml_schema import wrong


@final
class ReplayArm(Arm):
    """Goes to the recorded pose nearest to its goal."""

    outputs: ClassVar[int | None] = None
    synchronous_read: ClassVar[bool] = True
    absolute_encoders: ClassVar[bool] = True
    stops_alone: ClassVar[bool] = True

    def __init__(self, folder: Path, joints: Sequence[str]) -> None:
        robot, q = load(folder).arm
        if {*robot.joints} != {*joints}:
            of = f"a recording of {', '.join(joints)}, not of {', '.join(robot.joints)}"
            raise wrong(FILE, ("arm", "port"), str(folder), of)
        self.step = np.zeros(len(joints))
        self._recorded = q[:, [robot.joints.index(joint) for joint in joints]]
        self._at: Array = self._recorded[0]

    @classmethod
    def open(cls, cell: Cell, clock: Clock) -> Self:
        """Read the recording that the port names."""
        return cls(cell.folder / cell.arm.port, cell.robot.joints)

    def read(self) -> Array:
        """Return the joint angles, (j,)."""
        return self._at

    def poll_faults(self) -> None:
        """It has no faults."""

    def start_move(self, q: Array, seconds: float) -> None:
        """Jump to the recorded pose nearest to angles, (j,)."""
        self._at = self._recorded[np.abs(self._recorded - q).max(axis=1).argmin()]

    def stop(self) -> None:
        """It never moves."""

    def home(self) -> None:
        """It needs none."""

    def switch(self, output: int, *, on: bool) -> None:
        """The images are taken."""

    def close(self) -> None:
        """There is nothing to close."""
