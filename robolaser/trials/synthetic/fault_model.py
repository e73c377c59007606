"""A fault of a synthetic cell: a size, a form, and the stages of the chain that it perturbs in a run."""

from abc import ABC
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Annotated, Any, ClassVar, Self, dataclass_transform, final, get_type_hints

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.robot.kinematics import Robot
from robolaser.trials.synthetic.arm import ScrewArm
from robolaser.trials.synthetic.scanner import Light


@final
@dataclass(frozen=True)
class SyntheticRun:
    """Quantities that a fault may depend on."""

    robot: Robot  # the nominal arm
    q: Array  # joint readings, (n, j) [rad or m]
    qd: Array  # velocities at the reading, (n, j) [rad/s or m/s]
    time: Array  # of each pose, (n,) [s]
    middle: Array  # of the target, (3,) in the base frame [m]
    radius: float  # of the visible part of the target [m]
    payload_kg: float  # on the flange; it is not in the URDF

    @cached_property
    def arm(self) -> ScrewArm:
        """The same arm by independent formulas."""
        return ScrewArm(self.robot)

    @property
    def joints(self) -> tuple[str, ...]:
        """Joints that move the flange, base first."""
        return self.arm.joints

    @property
    def share(self) -> Array:
        """Share of the run at each pose, 0 to 1, (n,)."""
        return np.asarray((self.time - self.time.min()) / max(1e-9, float(np.ptp(self.time))))

    @property
    def order(self) -> Ints:
        """The poses in order of time, (n,)."""
        return np.argsort(self.time, kind="stable")

    def column(self, joint: str) -> int:
        """The column of a joint in q."""
        return self.robot.joints.index(joint)

    def torques(self, payload_kg: float) -> Array:
        """Load of each joint with a payload on the flange, (n, j) [Nm or N]."""
        return self.arm.torques(self.q, payload_kg)

    def relative_torque(self, joint: str) -> Array:
        """Load of a joint with the payload, over its largest one in the run, (n,)."""
        torque = self.torques(self.payload_kg)[:, self.column(joint)]
        return np.asarray(torque / max(1e-9, float(np.abs(torque).max())))

    def warmed(self, tau: float) -> Array:
        """0 at the start, towards 1 with a time constant, a share of the run, (n,)."""
        return 1.0 - np.exp(-self.share / tau)


Draw = Callable[[str, SyntheticRun, np.random.Generator], Any]
"""A random value of a field, by the fault's location and the run."""


def uniform(least: float, most: float, count: int | None = None) -> Draw:
    """A number between two others, or a tuple of so many."""
    return lambda where, run, rng: plain(rng.uniform(least, most, count))


def log_uniform(least: float, most: float, count: int | None = None) -> Draw:
    """A number between two others whose logarithm is uniform, or a tuple of so many."""
    return lambda where, run, rng: plain(np.exp(rng.uniform(np.log(least), np.log(most), count)))


def plain(values: Any) -> Any:
    """A float, or a tuple of floats."""
    return tuple(values.tolist()) if np.ndim(values) else float(values)


Angle = Annotated[float, uniform(-np.pi, np.pi)]  # [rad]
Coin = Annotated[bool, lambda where, run, rng: bool(rng.random() < 0.5)]
Way = Annotated[tuple[float, ...], uniform(-1.0, 1.0, 6)]  # a shift and a turn vector, over the size
OnTarget = Annotated[tuple[float, ...], uniform(-0.5, 0.5, 2)]  # over the target's radius
Places = Callable[[SyntheticRun], tuple[str, ...]]  # locations of a fault in a run; none if it is impossible


@dataclass_transform(frozen_default=True)
@dataclass(frozen=True)
class FaultModel(ABC):
    """One fault of one cell. A stage that a subclass does not override keeps its value.

    Class arguments are common to all faults of a class. Subclasses are dataclasses; their fields are the fault's form,
    each annotated with the `Draw` that samples it.
    """

    effect: ClassVar[str] = ""  # its name in the truth, that of the effect library if it has such an effect
    form: ClassVar[str] = ""  # its name among the kinds of worlds; by default the effect's
    sizes: ClassVar[tuple[float, float]] = (1.0, 1.0)  # usual in industry, least and most
    signed: ClassVar[bool] = False  # whether a sampled size may be negative
    location: ClassVar[str | None] = None  # its only location; None: one of `places`
    places: ClassVar[Places] = lambda run: run.joints  # its possible locations in a run; by default every joint
    parameter: ClassVar[str] = ""  # the effect library's parameter with the value `size`
    classes: ClassVar[tuple[str, ...]] = ()  # right classes, with `unknown`, of an effect outside the library
    also: ClassVar[tuple[tuple[str, str | None], ...]] = ()  # equivalent effects, and locations (None: its own)

    where: str  # the location that the truth names
    size: float  # its principal number in SI units; the other numbers are its form

    def __init_subclass__(cls, **traits: Any) -> None:
        """Set the class variables above."""
        for name, value in ({"form": traits.get("effect", "")} | traits).items():
            if name not in FaultModel.__annotations__:
                raise TypeError(f"{cls.__name__}: a fault model has no {name}")
            setattr(cls, name, value)
        dataclass(frozen=True)(cls)

    @classmethod
    def sample(cls, where: str, size: float, run: SyntheticRun, rng: np.random.Generator) -> Self:
        """A fault of this size whose sign and form are random."""
        sign = float(rng.choice([-1.0, 1.0])) if cls.signed else 1.0
        hints = get_type_hints(cls, include_extras=True)
        form = [hints[field.name].__metadata__[0](where, run, rng) for field in fields(cls)[2:]]
        return cls(where, size * sign, *form)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Its possible locations."""
        return cls.places(run) if cls.location is None else (cls.location,)

    def sites(self, run: SyntheticRun) -> tuple[str, ...]:
        """Locations that are right in a diagnosis."""
        return (self.where,)

    @property
    def also_right(self) -> tuple[tuple[str, str], ...]:
        """Equivalent effects of the library with their locations."""
        return tuple((effect, where or self.where) for effect, where in self.also)

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """The true values of equivalent parameters of the effect library, by name."""
        return {self.parameter: self.size} if self.parameter else {}

    @classmethod
    def is_tracked(cls) -> bool:
        """Whether a tracker can show it: a fault of the arm, its base, or the tracker."""
        stages = ("joints", "links", "flange", "measured")
        return any(getattr(cls, stage) is not getattr(FaultModel, stage) for stage in stages)

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """True joint angles, (n, j)."""
        return q

    def links(self, links: Array, run: SyntheticRun) -> Array:
        """True placements of the joints, (n, j, 4, 4)."""
        return links

    def flange(self, T_base_flange: Array, run: SyntheticRun) -> Array:
        """True pose of the flange, (n, 4, 4)."""
        return T_base_flange

    def mount(self, T_flange_camera: Array, run: SyntheticRun) -> Array:
        """True pose of the camera on the flange, (n, 4, 4)."""
        return T_flange_camera

    def lens(self, terms: Array) -> Array:
        """OpenCV's k1 k2 p1 p2 k3, (5,)."""
        return terms

    def zoom(self, depth: Array) -> Array:
        """Relative error of the image size of points at depths (m,) [m], (m,)."""
        return np.zeros_like(depth)

    def light(self, light: Light, run: SyntheticRun) -> Light:
        """The true light at each pose."""
        return light

    def stripe(self, tilt: Array) -> Array:
        """Error of the stripe's centre, (m,) [px], by the surface's tilt [rad]."""
        return np.zeros_like(tilt)

    def height(self, along: Array, run: SyntheticRun) -> Array:
        """Height error of the target, (m,) [m], at points in it, (m, 2) [m] from its middle."""
        return np.zeros(len(along))

    def printed(self, along: Array, run: SyntheticRun) -> Array:
        """Nominal coordinates of points in the target, (m, 2) [m] from its middle."""
        return along

    def measured(self, points: Array) -> Array:
        """Points measured by a tracker, (m, 3) [m] in its frame."""
        return points

    def shots(self, pixel: Array, shot: Ints, rng: np.random.Generator) -> Array:
        """Pixels as read, (rows, 2) [px]; `shot` numbers each row's point."""
        return pixel


def flange_poses(run: SyntheticRun, faults: Sequence[FaultModel]) -> Array:
    """True pose of the flange of an arm with these faults, (n, 4, 4)."""
    q, links = run.q, np.tile(run.arm.links, (len(run.q), 1, 1, 1))
    for fault in faults:
        q, links = fault.joints(q, run), fault.links(links, run)
    T_base_flange = run.arm.forward(q, links)
    for fault in faults:
        T_base_flange = fault.flange(T_base_flange, run)
    return T_base_flange
