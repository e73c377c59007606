"""Joints that yield to weight or to a cable."""

from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel, plain, uniform
from robolaser.trials.synthetic.fault_models.joints import play_lags, turned
from robolaser.trials.synthetic.run import SyntheticRun

LEAST_SWING_NM = 0.2  # of the torque over the run
ALIKE = 0.98  # correlation of the torques with and without payload
WRIST = 3  # joints


def joints_that_yield(run: SyntheticRun) -> tuple[str, ...]:
    """Joints whose torque from the URDF's masses alone goes with the whole torque: no other can be named."""
    whole = run.arm.torques(run.q, run.payload_kg)
    masses = run.arm.torques(run.q, 0.0)
    alike = [
        np.corrcoef(*pair)[0, 1] if min(np.ptp(pair, axis=1)) > LEAST_SWING_NM else 0.0
        for pair in zip(whole.T, masses.T, strict=True)
    ]
    return tuple(joint for joint in run.arm.joints if alike[run.column(joint)] > ALIKE)


@final
class GearWindup(FaultModel, effect="joint_compliance", sizes=(2e-4, 2.5e-3), places=joints_that_yield):
    """The joint gives way under all that it carries, payload and all: less for each further newton metre."""

    hardening: Annotated[float, uniform(0.0, 0.3)]

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Sunk, by `size` [rad] under the largest torque of the run."""
        load = run.relative_torque(self.where)
        sunk = self.size * load * (1.0 + self.hardening) / (1.0 + self.hardening * np.abs(load))
        return turned(q, run.column(self.where), -sunk)


@final
class HystereticWindup(
    FaultModel,
    effect="hysteresis",
    sizes=(3e-4, 3e-3),
    places=joints_that_yield,
    classes=("elasticity", "transmission"),
    also=(("joint_compliance", None), ("backlash", None)),
):
    """A joint gives way under its torque, by `size` [rad] at most, and comes back only once friction is overcome."""

    friction: Annotated[float, uniform(0.2, 0.7)]  # width of the hysteresis over the range of the torque

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """By the torque less a play operator's lag."""
        load = run.relative_torque(self.where)
        lags = play_lags(run, load, self.friction * float(np.ptp(load)), 0.0)
        return turned(q, run.column(self.where), -self.size * (load - lags))


@final
class CableForce(
    FaultModel,
    effect="hose",
    sizes=(5e-4, 4e-3),
    places=lambda run: run.arm.joints[-2:-1],
    classes=("elasticity", "transmission"),
):
    """A cable, a spring from the ceiling to the flange, turns the wrist; the library has no such effect.

    It is laid along the whole wrist; the truth names the last joint but one.
    """

    anchor: Annotated[
        tuple[float, ...],
        lambda where, run, rng: plain(run.middle + rng.uniform(-1, 1, 3) * [0.6, 0.6, 0.2] + [0.0, 0.0, 1.2]),
    ]  # in the base frame [m]
    slack: Annotated[float, uniform(0.1, 0.5)]  # how long it is [m]

    def sites(self, run: SyntheticRun) -> tuple[str, ...]:
        """The whole wrist."""
        return run.arm.joints[-WRIST:]

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
