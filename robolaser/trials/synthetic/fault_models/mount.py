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


@final
@dataclass(frozen=True)
class DroopingBracket(FaultModel):
    """The bracket is a beam from the flange to the camera, which the camera's weight bends.

    Gere, Timoshenko, Mechanics of Materials: the end of a cantilever of length L sinks by d and turns by 3 d / (2 L).
    """

    effect: ClassVar[str] = "hand_eye_sag"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 2e-3)
    location: ClassVar[str | None] = "hand_eye"

    along: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """How far it yields along the beam, as a share of across."""
        return (rng.uniform(0.5, 1.0),)

    def mount(self, T_flange_camera: Array, run: SyntheticRun) -> Array:
        """Sunk by `size` [m] where the weight is across the beam, and turned by as much as that bends it."""
        down = np.einsum("nba,b->na", run.arm.forward(run.q)[:, :3, :3], run.arm.down)
        beam = T_flange_camera[:, :3, 3]
        length = np.linalg.norm(beam, axis=1, keepdims=True)
        inline = (beam * down).sum(axis=1, keepdims=True) * beam / length**2
        moved = T_flange_camera.copy()
        moved[:, :3, 3] += self.size * (down - (1.0 - self.along) * inline)
        turn = 1.5 * self.size / length**2 * np.cross(beam, down)
        moved[:, :3, :3] = Rotation.from_rotvec(turn).as_matrix() @ moved[:, :3, :3]
        return moved
