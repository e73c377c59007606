"""Joints that yield to weight or to a cable."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models.joints import turned
from robolaser.trials.synthetic.run import SyntheticRun

LEAST_SWING_NM = 0.2  # of the torque over the run
ALIKE = 0.98  # correlation of the torques with and without payload
WRIST = 3  # joints


@final
@dataclass(frozen=True)
class GearWindup(FaultModel):
    """The joint gives way under all that it carries, payload and all: less for each further newton metre."""

    effect: ClassVar[str] = "joint_compliance"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 2.5e-3)

    hardening: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """How much it stiffens."""
        return (rng.uniform(0.0, 0.3),)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Joints whose torque from the URDF's masses alone goes with the whole torque: no other can be named."""
        whole = run.arm.torques(run.q, run.payload_kg)
        masses = run.arm.torques(run.q, 0.0)
        alike = [
            np.corrcoef(*pair)[0, 1] if min(np.ptp(pair, axis=1)) > LEAST_SWING_NM else 0.0
            for pair in zip(whole.T, masses.T, strict=True)
        ]
        return tuple(joint for joint in run.arm.joints if alike[run.column(joint)] > ALIKE)

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Sunk, by `size` [rad] under the largest torque of the run."""
        column = run.column(self.where)
        torque = run.arm.torques(run.q, run.payload_kg)[:, column]
        load = torque / max(1e-9, float(np.abs(torque).max()))
        return turned(q, column, -self.size * load * (1.0 + self.hardening) / (1.0 + self.hardening * np.abs(load)))


@final
@dataclass(frozen=True)
class CableForce(FaultModel):
    """A cable, a spring from the ceiling to the flange, turns the wrist; the library has no such effect."""

    effect: ClassVar[str] = "hose"
    sizes: ClassVar[tuple[float, float]] = (5e-4, 4e-3)
    classes: ClassVar[tuple[str, ...]] = ("elasticity", "transmission")

    anchor: tuple[float, float, float]
    slack: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Where it hangs, and how long it is [m]."""
        anchor = run.middle + rng.uniform(-1, 1, 3) * [0.6, 0.6, 0.2] + [0.0, 0.0, 1.2]
        return tuple(anchor.tolist()), rng.uniform(0.1, 0.5)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """It is laid along the whole wrist; the truth names the last joint but one."""
        return run.arm.joints[-2:-1]

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """The wrist's joints turned by the force against their stiffness, at most by `size` [rad]."""
        away = np.array(self.anchor) - run.arm.forward(q)[:, :3, 3]
        length = np.linalg.norm(away, axis=1)
        pull = away * (np.maximum(0.0, length - self.slack) / length)[:, None]
        wrist = [run.column(joint) for joint in run.arm.joints[-WRIST:]]
        turn = np.einsum("nij,ni->nj", run.arm.levers(q)[:, :, wrist], pull)
        q = q.copy()
        q[:, wrist] += self.size * turn / np.abs(turn).max()
        return q
