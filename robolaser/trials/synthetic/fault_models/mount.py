"""Faults of the bracket that holds the camera on the flange."""

from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3
from robolaser.trials.synthetic.fault_model import FaultModel, Way, uniform
from robolaser.trials.synthetic.run import SyntheticRun


@final
class BracketCreep(FaultModel, effect="hand_eye_drift", sizes=(3e-4, 3e-3), location="hand_eye"):
    """The camera moves on its bracket, in proportion to the time or to its logarithm."""

    # how soon it slows down, as a share of the run; 0: never
    settling: Annotated[float, lambda where, run, rng: float(rng.choice([0.0, rng.uniform(0.02, 0.3)]))]
    way: Way

    def mount(self, T_flange_camera: Array, run: SyntheticRun) -> Array:
        """Off by up to `size` [m] and radians at the end."""
        s = self.settling
        share = np.log1p(run.share / s) / np.log1p(1.0 / s) if s else run.share
        way = self.size * share[:, None] * np.array(self.way)
        moved = T_flange_camera.copy()
        moved[:, :3, 3] += way[:, :3]
        moved[:, :3, :3] = moved[:, :3, :3] @ exp_so3(way[:, 3:])
        return moved


@final
class DroopingBracket(FaultModel, effect="hand_eye_sag", sizes=(2e-4, 2e-3), location="hand_eye"):
    """The bracket is a beam from the flange to the camera, which the camera's weight bends.

    Gere, Timoshenko, Mechanics of Materials: the end of a cantilever of length L sinks by d and turns by 3 d / (2 L).
    """

    along: Annotated[float, uniform(0.5, 1.0)]  # how far it yields along the beam, as a share of across

    def mount(self, T_flange_camera: Array, run: SyntheticRun) -> Array:
        """Sunk by `size` [m] where the weight is across the beam, and turned by as much as that bends it."""
        down = np.einsum("nba,b->na", run.arm.forward(run.q)[:, :3, :3], run.arm.down)
        beam = T_flange_camera[:, :3, 3]
        length = np.linalg.norm(beam, axis=1, keepdims=True)
        inline = (beam * down).sum(axis=1, keepdims=True) * beam / length**2
        moved = T_flange_camera.copy()
        moved[:, :3, 3] += self.size * (down - (1.0 - self.along) * inline)
        moved[:, :3, :3] = exp_so3(1.5 * self.size / length**2 * np.cross(beam, down)) @ moved[:, :3, :3]
        return moved
