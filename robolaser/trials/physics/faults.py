"""Faults whose consequences MuJoCo computes: what gives way comes to rest under the weight of all that it carries."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.physics.elements import BRACKET, FOOT, Gear, Load, SpringHinge
from robolaser.trials.physics.mujoco_arm import MujocoArm
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models.joint_loads import GearWindup
from robolaser.trials.synthetic.run import SyntheticRun

CAMERA_AT = (0.06, 0.0, 0.04)  # of the scanner's centre of mass, seen from the flange [m]
UNSTATED_KG = (1.0, 3.0)
HARD = 2e5  # of a gear that has play and little else [Nm/rad]
LEAST_LENGTH_M = 0.05


@dataclass(frozen=True)
class PhysicalFault(FaultModel):
    """Something that gives way, by `size` [rad] at most over the run."""

    form: ClassVar[str]  # what the kinds of worlds call it

    @abstractmethod
    def arm(self, run: SyntheticRun, stiffness: float) -> MujocoArm:
        """The arm with what gives way [Nm/rad]."""

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """At its location, or at joints that bear weight enough to be told from joints with an offset."""
        return GearWindup.locations(run) if cls.location is None else (cls.location,)

    def stiffness(self, run: SyntheticRun) -> float:
        """That gives way by `size` under the largest torque of the run [Nm/rad]."""
        return float(np.abs(self.arm(run, 1.0).weights(run.q)).max()) / self.size

    def flange(self, T_base_flange: Array, run: SyntheticRun) -> Array:
        """Where the arm comes to rest, by as much beside where it would be if it were rigid."""
        if not self.size:
            return T_base_flange
        at_rest, _ = self.arm(run, self.stiffness(run)).at_rest(run.q)
        return at_rest @ np.linalg.inv(run.arm.forward(run.q)) @ T_base_flange

    def mount(self, T_flange_camera: Array, run: SyntheticRun) -> Array:
        """With the bracket where it comes to rest."""
        if not self.size:
            return T_flange_camera
        flange, bracket = self.arm(run, self.stiffness(run)).at_rest(run.q)
        return np.linalg.inv(flange) @ bracket @ T_flange_camera


@final
@dataclass(frozen=True)
class SoftDrive(PhysicalFault):
    """A joint's gear is a spring, or its servo has no integrator: its gain times its error bears the weight."""

    effect: ClassVar[str] = "joint_compliance"
    form: ClassVar[str] = "soft_drive"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 2.5e-3)

    servo: bool

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Whether it is the servo."""
        return (bool(rng.random() < 0.5),)

    def arm(self, run: SyntheticRun, stiffness: float) -> MujocoArm:
        """With the scanner that the URDF lacks."""
        return MujocoArm(run.arm.robot, gears={self.where: Gear(stiffness, servo=self.servo)}, load=scanner(run))

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Its compliance."""
        return {"compliance": 1.0 / self.stiffness(run)}


@final
@dataclass(frozen=True)
class UnstatedPayload(PhysicalFault):
    """A joint's gear is a spring, and the flange carries far more than anybody stated."""

    effect: ClassVar[str] = "joint_compliance"
    form: ClassVar[str] = "unstated_payload"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 2.5e-3)

    payload_kg: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """The payload [kg]."""
        return (float(rng.uniform(*UNSTATED_KG)),)

    def arm(self, run: SyntheticRun, stiffness: float) -> MujocoArm:
        """With the payload."""
        return MujocoArm(run.arm.robot, gears={self.where: Gear(stiffness)}, load=Load(self.payload_kg, CAMERA_AT))


@final
@dataclass(frozen=True)
class PlayUnderWeight(PhysicalFault):
    """A joint has `size` [rad] of play, and the arm's weight decides on which side it rests, not the approach."""

    effect: ClassVar[str] = "play_under_weight"
    form: ClassVar[str] = "play_under_weight"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 3e-3)
    classes: ClassVar[tuple[str, ...]] = ("transmission", "elasticity")

    friction: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """The torque that pushes it to one end, as a share of the largest."""
        return (float(rng.uniform(0.05, 0.5)),)

    def stiffness(self, run: SyntheticRun) -> float:
        """Of the gear once the play is used up."""
        return HARD

    def arm(self, run: SyntheticRun, stiffness: float) -> MujocoArm:
        """With the scanner that the URDF lacks."""
        column = run.column(self.where)
        most = float(np.abs(run.arm.torques(run.q, run.payload_kg)[:, column]).max())
        gear = Gear(stiffness, play=self.size, centring=2.0 * self.friction * most / self.size)
        return MujocoArm(run.arm.robot, gears={self.where: gear}, load=scanner(run))

    @property
    def also_right(self) -> tuple[tuple[str, str], ...]:
        """What it is in the end: lost motion, and giving way."""
        return (("backlash", self.where), ("joint_compliance", self.where))


@final
@dataclass(frozen=True)
class SoftBase(PhysicalFault):
    """What the arm stands on turns about axes somewhat below the base, one softer than the other."""

    effect: ClassVar[str] = "base_compliance"
    form: ClassVar[str] = "soft_base"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 3e-3)
    location: ClassVar[str | None] = "base"

    ratio: float
    depth: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """How much stiffer it is about y than about x, and how far down the axes are [m]."""
        return float(np.exp(rng.uniform(-0.7, 0.7))), float(rng.uniform(0.0, 0.05))

    def arm(self, run: SyntheticRun, stiffness: float) -> MujocoArm:
        """On two hinges."""
        at = (0.0, 0.0, -self.depth)
        springs = [
            SpringHinge(FOOT, (1.0, 0.0, 0.0), at, stiffness),
            SpringHinge(FOOT, (0.0, 1.0, 0.0), at, stiffness * self.ratio),
        ]
        return MujocoArm(run.arm.robot, hinges=springs, load=scanner(run))


@final
@dataclass(frozen=True)
class GivingMount(PhysicalFault):
    """The bracket turns about the flange under the weight of the scanner, one way more easily than another."""

    effect: ClassVar[str] = "hand_eye_sag"
    form: ClassVar[str] = "giving_mount"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 4e-3)
    location: ClassVar[str | None] = "hand_eye"

    ratios: tuple[float, float, float]

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """How stiff it is about each axis of the flange, against the others."""
        return (tuple(np.exp(rng.uniform(-0.5, 0.5, 3)).tolist()),)

    def arm(self, run: SyntheticRun, stiffness: float) -> MujocoArm:
        """With the scanner on three hinges."""
        springs = _universal(BRACKET, np.eye(3), np.zeros(3), stiffness, self.ratios)
        return MujocoArm(run.arm.robot, hinges=springs, load=scanner(run))


@final
@dataclass(frozen=True)
class BendingLink(PhysicalFault):
    """The link before a joint bends and twists in its middle."""

    effect: ClassVar[str] = "link_compliance"
    form: ClassVar[str] = "bending_link"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 2.5e-3)

    twist: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """How stiff it is in torsion, against bending."""
        return (float(rng.uniform(0.6, 1.0)),)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Joints but the first that a link of some length carries."""
        lengths = np.linalg.norm(run.arm.links[:, :3, 3], axis=1)
        return tuple(joint for joint in run.arm.joints[1:] if lengths[run.column(joint)] > LEAST_LENGTH_M)

    def arm(self, run: SyntheticRun, stiffness: float) -> MujocoArm:
        """With three hinges in the middle of the link."""
        T = run.arm.links[run.column(self.where)]
        beam = T[:3, :3].T @ T[:3, 3]
        across = np.linalg.svd(beam[None])[2][1:]
        axes = np.vstack([across, beam / np.linalg.norm(beam)])
        springs = _universal(self.where, axes, -beam / 2, stiffness, (1.0, 1.0, self.twist))
        return MujocoArm(run.arm.robot, hinges=springs, load=scanner(run))


PHYSICAL: dict[str, type[PhysicalFault]] = {fault.form: fault for fault in PhysicalFault.__subclasses__()}  # by form


def scanner(run: SyntheticRun) -> Load:
    """The scanner, which no URDF knows of."""
    return Load(run.payload_kg, CAMERA_AT)


def _universal(
    before: str, axes: Array, at: Array, stiffness: float, ratios: tuple[float, float, float]
) -> list[SpringHinge]:
    """Hinges about three axes through one point."""
    x, y, z = at.tolist()
    return [
        SpringHinge(before, tuple(axis.tolist()), (x, y, z), stiffness * ratio)
        for axis, ratio in zip(axes, ratios, strict=True)
    ]
