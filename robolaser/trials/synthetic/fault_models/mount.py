"""Faults of the bracket that holds the camera on the flange."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class BracketCreep(FaultModel):
    """The camera moves on its bracket, in proportion to the time or to its logarithm."""

    effect: ClassVar[str] = "hand_eye_drift"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 3e-3)
    location: ClassVar[str | None] = "hand_eye"

    settling: float
    way: tuple[float, ...]

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """How soon it slows down, as a share of the run (0: never), and which way."""
        return rng.choice([0.0, rng.uniform(0.02, 0.3)]), tuple(rng.uniform(-1.0, 1.0, 6).tolist())

    def mount(self, T_flange_camera: Array, run: SyntheticRun) -> Array:
        """Off by up to `size` [m] and radians at the end."""
        s = self.settling
        share = np.log1p(run.share / s) / np.log1p(1.0 / s) if s else run.share
        way = self.size * share[:, None] * np.array(self.way)
        moved = T_flange_camera.copy()
        moved[:, :3, 3] += way[:, :3]
        moved[:, :3, :3] = moved[:, :3, :3] @ Rotation.from_rotvec(way[:, 3:]).as_matrix()
        return moved
