"""An arm that is a recording: it jumps to where the recorded one stood."""

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell.arm import Arm
from robolaser.data.loading import load
from robolaser.errors import ArmDiffers


@final
class Replay(Arm):
    """Stands at the recorded pose nearest to where it is sent."""

    all_at_once: ClassVar[bool] = True
    knows_itself: ClassVar[bool] = True

    def __init__(self, folder: Path, joints: Sequence[str]) -> None:
        q = load(folder).poses.q
        if q is None or q.shape[1] != len(joints):
            raise ArmDiffers("replay", len(joints), 0 if q is None else q.shape[1])
        self.step = np.zeros(len(joints))
        self._recorded = q
        self._at: Array = q[0]

    def read(self) -> Array:
        """Where it is now, (j,)."""
        return self._at

    def watch(self) -> None:
        """Nothing befalls it."""

    def go(self, q: Array, seconds: float) -> None:
        """Set out to angles, (j,)."""
        self._at = self._recorded[np.abs(self._recorded - q).max(axis=1).argmin()]

    def stop(self) -> None:
        """It never moves."""

    def home(self) -> None:
        """It was never lost."""

    def light(self, output: int) -> None:
        """The images are taken."""

    def dark(self, output: int) -> None:
        """The images are taken."""

    def close(self) -> None:
        """There is nothing to let go of."""
