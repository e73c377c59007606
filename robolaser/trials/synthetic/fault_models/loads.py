"""Elastic deflection under weight or a cable's pull: by formulas, or by MuJoCo's equilibrium under all loads."""

from collections.abc import Sequence
from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import inverse
from robolaser.trials.synthetic.fault_model import Coin, FaultModel, SyntheticRun, log_uniform, plain, uniform
from robolaser.trials.synthetic.fault_models.joints import play_lags, turned
from robolaser.trials.synthetic.fault_models.links import beam, joints_on_long_links
from robolaser.trials.synthetic.mujoco_arm import BRACKET, FOOT, MujocoArm, Spring

LEAST_SWING_NM = 0.2  # of the torque over the run
ALIKE = 0.98  # correlation of the torques with and without payload
WRIST = 3  # joints
HARD = 2e5  # stiffness of a gear whose main fault is play [Nm/rad]


def joints_that_yield(run: SyntheticRun) -> tuple[str, ...]:
    """Joints whose torque by the URDF's masses correlates with the whole torque: no other can be named."""
    whole = run.torques(run.payload_kg)
    masses = run.torques(0.0)
    alike = [
        np.corrcoef(*pair)[0, 1] if min(np.ptp(pair, axis=1)) > LEAST_SWING_NM else 0.0
        for pair in zip(whole.T, masses.T, strict=True)
    ]
    return tuple(joint for joint in run.joints if alike[run.column(joint)] > ALIKE)


@final
class GearWindup(FaultModel, effect="joint_compliance", sizes=(2e-4, 2.5e-3), places=joints_that_yield):
    """The joint deflects under its whole load with the payload, and hardens with it."""

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
    """A joint deflects under its torque, by `size` [rad] at most, and returns only once friction is overcome."""

    friction: Annotated[float, uniform(0.2, 0.7)]  # width of the hysteresis over the range of the torque

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        load = run.relative_torque(self.where)
        lags = play_lags(run, load, self.friction * float(np.ptp(load)), 0.0)
        return turned(q, run.column(self.where), -self.size * (load - lags))


@final
class CableForce(
    FaultModel,
    effect="hose",
    sizes=(5e-4, 4e-3),
    places=lambda run: run.joints[-2:-1],
    classes=("elasticity", "transmission"),
):
    """A cable, a spring from the ceiling to the flange, turns the wrist; the library has no such effect.

    It runs along the whole wrist; the truth names the last joint but one.
    """

    anchor: Annotated[
        tuple[float, ...],
        lambda where, run, rng: plain(run.middle + rng.uniform(-1, 1, 3) * [0.6, 0.6, 0.2] + [0.0, 0.0, 1.2]),
    ]  # in the base frame [m]
    slack: Annotated[float, uniform(0.1, 0.5)]  # how long it is [m]

    def sites(self, run: SyntheticRun) -> tuple[str, ...]:
        return run.joints[-WRIST:]

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """The wrist's joints turned by the force against their stiffness, at most by `size` [rad]."""
        away = np.array(self.anchor) - run.arm.forward(q)[:, :3, 3]
        length = np.linalg.norm(away, axis=1)
        pull = away * (np.maximum(0.0, length - self.slack) / length)[:, None]
        wrist = [run.column(joint) for joint in run.joints[-WRIST:]]
        turn = np.einsum("nij,ni->nj", run.arm.levers(q)[:, :, wrist], pull)
        q = q.copy()
        q[:, wrist] += self.size * turn / np.abs(turn).max()
        return q


class SpringFault(FaultModel, places=joints_that_yield):
    """A spring that deflects by `size` [rad] at most over the run."""

    def springs(self, run: SyntheticRun, stiffness: float) -> list[Spring]:
        """Its springs [Nm/rad]: the gear of its joint, unless a fault overrides this."""
        return [Spring(self.where, stiffness)]

    def load_kg(self, run: SyntheticRun) -> float:
        """On the bracket."""
        return run.payload_kg

    def stiffness(self, run: SyntheticRun) -> float:
        """Stiffness that gives a deflection of `size` under the largest torque of the run [Nm/rad]."""
        return float(np.abs(self.arm(run, 1.0).weights(run.q)).max()) / self.size

    def arm(self, run: SyntheticRun, stiffness: float) -> MujocoArm:
        """The arm with its springs [Nm/rad]."""
        return MujocoArm(run.robot, self.springs(run, stiffness), self.load_kg(run))

    def flange(self, T_base_flange: Array, run: SyntheticRun) -> Array:
        """The flange's pose at rest: displaced by the deflection from the rigid arm."""
        if not self.size:
            return T_base_flange
        at_rest, _ = self.arm(run, self.stiffness(run)).at_rest(run.q)
        return np.asarray(at_rest @ inverse(run.arm.forward(run.q)) @ T_base_flange)

    def mount(self, T_flange_camera: Array, run: SyntheticRun) -> Array:
        """The camera's pose with the bracket at rest."""
        if not self.size:
            return T_flange_camera
        flange, bracket = self.arm(run, self.stiffness(run)).at_rest(run.q)
        return np.asarray(inverse(flange) @ bracket @ T_flange_camera)


@final
class SoftDrive(SpringFault, effect="joint_compliance", form="soft_drive", sizes=(2e-4, 2.5e-3)):
    """A joint's gear is a spring, or its servo has no integrator: its gain times its error bears the weight."""

    servo: Coin  # which of them; at rest they are equal

    def values(self, run: SyntheticRun) -> dict[str, float]:
        return {"compliance": 1.0 / self.stiffness(run)}


@final
class UnstatedPayload(SpringFault, effect="joint_compliance", form="unstated_payload", sizes=(2e-4, 2.5e-3)):
    """A joint's gear is a spring, and the payload is far larger than stated."""

    payload_kg: Annotated[float, uniform(1.0, 3.0)]

    def load_kg(self, run: SyntheticRun) -> float:
        return self.payload_kg


@final
class PlayUnderWeight(
    SpringFault,
    effect="play_under_weight",
    sizes=(3e-4, 3e-3),
    classes=("transmission", "elasticity"),
    also=(("backlash", None), ("joint_compliance", None)),
):
    """A joint has `size` [rad] of play, and the arm's weight decides on which side it rests, not the approach.

    The effects are lost motion and compliance.
    """

    friction: Annotated[float, uniform(0.05, 0.5)]  # torque that pushes it to one end, as a share of the largest

    def stiffness(self, run: SyntheticRun) -> float:
        """Of the gear once the play is used up."""
        return HARD

    def springs(self, run: SyntheticRun, stiffness: float) -> list[Spring]:
        most = float(np.abs(run.torques(run.payload_kg)[:, run.column(self.where)]).max())
        return [Spring(self.where, stiffness, play=self.size, centring=2.0 * self.friction * most / self.size)]


@final
class SoftBase(SpringFault, effect="base_compliance", form="soft_base", sizes=(2e-4, 3e-3), location="base"):
    """The foundation turns about axes somewhat below the base, one softer than the other."""

    ratio: Annotated[float, log_uniform(np.exp(-0.7), np.exp(0.7))]  # of its stiffness about y to that about x
    depth: Annotated[float, uniform(0.0, 0.05)]  # of the axes below the base [m]

    def sites(self, run: SyntheticRun) -> tuple[str, ...]:
        """A base that tilts turns the first joint's axis."""
        return self.where, run.joints[0]

    def springs(self, run: SyntheticRun, stiffness: float) -> list[Spring]:
        at = np.array([0.0, 0.0, -self.depth])
        return _hinges(FOOT, np.eye(3)[:2], at, (stiffness, stiffness * self.ratio))


@final
class GivingMount(SpringFault, effect="hand_eye_sag", form="giving_mount", sizes=(3e-4, 4e-3), location="hand_eye"):
    """The bracket turns about the flange under the weight of the scanner, with anisotropic stiffness."""

    ratios: Annotated[tuple[float, ...], log_uniform(np.exp(-0.5), np.exp(0.5), 3)]  # of its stiffness about x, y, z

    def springs(self, run: SyntheticRun, stiffness: float) -> list[Spring]:
        return _hinges(BRACKET, np.eye(3), np.zeros(3), [stiffness * ratio for ratio in self.ratios])


@final
class BendingLink(
    SpringFault, effect="link_compliance", form="bending_link", sizes=(2e-4, 2.5e-3), places=joints_on_long_links
):
    """The link before a joint bends and twists in its middle."""

    twist: Annotated[float, uniform(0.6, 1.0)]  # stiffness in torsion over that in bending

    def springs(self, run: SyntheticRun, stiffness: float) -> list[Spring]:
        """Two across the link and one along it."""
        L = beam(run, self.where)
        axes = np.vstack([np.linalg.svd(L[None])[2][1:], L / np.linalg.norm(L)])
        return _hinges(self.where, axes, -L / 2, (stiffness, stiffness, stiffness * self.twist))


def _hinges(before: str, axes: Array, at: Array, stiffnesses: Sequence[float]) -> list[Spring]:
    """About axes through one point."""
    return [Spring(before, stiffness, axis, at) for axis, stiffness in zip(axes, stiffnesses, strict=True)]
