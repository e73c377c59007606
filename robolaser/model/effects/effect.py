"""A departure from the nominal model: a stage, a location, a few parameters, and how they change a value."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property, partial
from itertools import product
from typing import Any, ClassVar, NamedTuple, cast, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.duals import Dual, is_dual
from robolaser.model.effects.joints import moving_joints, turning_joints
from robolaser.model.effects.mechanism import MechanismPart
from robolaser.model.effects.requirements import passes, turning_joint
from robolaser.model.effects.run import Run, RunSummary
from robolaser.model.effects.sensor_sites import of_sensor, sensors_at, sites_of_sensors
from robolaser.model.sensors import parts_with_lens
from robolaser.model.stages import OF_ROWS, Perturbation, Stage
from robolaser.parameters import Parameter, Parameters, Values
from robolaser.robot.kinematics import Robot

__all__ = ["CarryOver", "Effect", "Run", "RunSummary", "Stage", "nonlinear", "parameter"]  # for effects

NOT_WARM = (
    "how far it has come in this recording is not known; it is taken as at the end of the calibrated run, warmed up. If"
    " it was not"
)

WHERE_SLIDING = {"rad": "m", "rad/Nm": "m/N", "kg rad/Nm": "kg m/N"}
"""Units of effects on the readings of a prismatic joint, by those at a revolute one."""


class Amplitude(NamedTuple):
    """A parameter of an effect that is zero when nominal."""

    name: str  # within the effect
    unit: str  # SI
    lower: float  # it is not below; zero where physics permits one sign only, else -bound
    bound: float  # it is not above
    # what is common in industry: fits, complexity penalties and detection limits are relative to it
    prior_scale: float


def parameter(*, unit: str, bound: float, prior_scale: float, lower: float | None = None) -> Any:
    """Declare an amplitude, see `Amplitude`; it is within ±bound where no lower bound is given."""
    return field(metadata={"amplitude": (unit, -bound if lower is None else lower, bound, prior_scale)})


def nonlinear(*, unit: str, lower: float, upper: float, nominal: float, tried: Sequence[float] = ()) -> Any:
    """Declare a nonlinear parameter, such as a frequency: it has no meaning while all amplitudes are zero.

    Within [lower, upper] the misfit may have many minima: `tried` are start values for all data, else `Effect.grid`
    gives them.
    """
    return field(metadata={"nonlinear": (unit, nominal, lower, upper), "tried": tried or (nominal,)})


@dataclass(frozen=True)
class Effect(ABC):
    """A departure from the nominal model at one location, with one value of its parameters for each candidate.

    A subclass declares the class data below and its parameters, the principal one first, and implements `apply`. With
    all amplitudes at zero, `apply` changes nothing, exactly, whatever the nonlinear parameters. Its output is
    smooth in the amplitudes, but need not be smooth in the nonlinear parameters.

    Attributes:
        name: Its name in commands and files.
        title: A short description.
        clause: The same as a clause, with {where} for the location.
        caveat: A caveat for results.
        remedy: The remedy in the cell, with {where} for the location.
        reference: Source of its physics and typical size.
        stage: The stage, from encoder and image to residual, at which it acts.
        cause: The class of causes that it belongs to, such as `transmission`: the class can be identified even
            where its members cannot. Empty: a class of its own.
        site: The location, one of `camera laser hand_eye target base timing image tool measuring_system`; empty: each
            moving joint.
        needs: Required data, besides values at the stage, see `requirements`.
        depends_on_trajectory: Whether the change at a pose or point depends on others.
        harmonics: Of waves of its joint's angle: multiples of its one nonlinear parameter, a frequency; its amplitudes
            are the sines and cosines of these waves.
        begins: Whether its one nonlinear parameter is the share of the run at which it begins, constant from then on.
        in_urdf: Whether a URDF can represent it: then the exported robot does.
        looks_like_arm: Whether it is not of the arm, but an error of the arm looks the same: files of the arm lack it.
        where: Its location: a joint's name, or its site; a sensor's own as `left.laser`.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    clause: ClassVar[str] = ""
    caveat: ClassVar[str] = "valid within the range of the measured poses"
    remedy: ClassVar[str] = "Use the corrected model."
    reference: ClassVar[str]
    stage: ClassVar[Stage]
    cause: ClassVar[str] = ""
    site: ClassVar[str] = ""
    needs: ClassVar[tuple[Callable[[Dataset], str], ...]] = ()
    depends_on_trajectory: ClassVar[bool] = False
    harmonics: ClassVar[tuple[int, ...]] = ()
    begins: ClassVar[bool] = False
    in_urdf: ClassVar[bool] = False
    looks_like_arm: ClassVar[bool] = False

    where: str

    @abstractmethod
    def apply(self, value: Array, run: Run, /) -> Array:
        """The value after the stage; its shape may only grow from 1 to n or m."""

    @classmethod
    def sites(cls, robot: Robot | None) -> tuple[str, ...]:
        """Its possible locations in an arm and its sensor, if the data have all that it needs."""
        joints = turning_joints if turning_joint in cls.needs else moving_joints
        return (cls.site,) if cls.site else joints(robot)

    @classmethod
    def stage_in(cls, dataset: Dataset) -> Stage:
        """The stage at which it acts in these data."""
        return cls.stage

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Why these data cannot test it, such as "no joint velocities in the data"; "" if they can."""
        by_sensor = cls.missing_by_sensor(dataset)
        reason = "" if "" in by_sensor else by_sensor[0]
        return reason or ("" if cls.sites(dataset.robot) else "this robot has no location for it")

    @classmethod
    def missing_by_sensor(cls, dataset: Dataset) -> tuple[str, ...]:
        """Likewise of each sensor."""
        return tuple(
            next(filter(None, (passes(cls.stage_in(part), part), *(need(part) for need in cls.needs))), "")
            for part in parts_with_lens(dataset)
        )

    @classmethod
    def locations(cls, dataset: Dataset) -> tuple[str, ...]:
        """Locations at which these data can test it; empty if something is missing.

        If several sensors have its site, each sensor's is a location: `left.laser`.
        """
        if cls.missing(dataset):
            return ()
        if not cls.site:
            return cls.sites(dataset.robot)
        if cls.stage not in OF_ROWS:
            return (cls.site,)
        missing = cls.missing_by_sensor(dataset)
        return tuple(sites_of_sensors(cls.site, dataset, lambda number: not missing[number]))

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Values of its nonlinear parameters worth trying for these data, (g, number of nonlinear parameters).

        Dense enough that descents from them reach the best minimum.
        """
        tried = (f.metadata["tried"] for f in fields(cls) if "tried" in f.metadata)
        return np.array(list(product(*tried)), dtype=np.float64)

    @classmethod
    def usual_shape(cls, dataset: Dataset, where: str) -> dict[str, float]:
        """Nonlinear parameters of a simulated effect by name, where their nominal values are meaningless."""
        return {}

    def carried_to(self, run: Run, found_in: RunSummary | None) -> "CarryOver":
        """Its state in another run.

        Args:
            run: The other run, as `continued` gives it.
            found_in: The run in which it was found; None if unknown.
        """
        reason = self.hindrance(run)
        return CarryOver(None, doubt=reason) if reason else CarryOver(self)

    def hindrance(self, run: Run) -> str:
        """Why it cannot act in a run; "" if it can."""
        return self.missing(run.dataset)

    def parts(self, run: Run) -> tuple[MechanismPart, ...]:
        """Its parts in a simulator, of one candidate; empty: there are none, and a note says so."""
        return ()

    @classmethod
    @cache
    def amplitudes(cls) -> tuple[Amplitude, ...]:
        """Its parameters that are zero when nominal, the principal one first."""
        return tuple(Amplitude(f.name, *f.metadata["amplitude"]) for f in fields(cls) if "amplitude" in f.metadata)

    @classmethod
    def nonlinear_parameters(cls) -> tuple[Parameter, ...]:
        """Its nonlinear parameters."""
        return tuple(Parameter(f.name, *f.metadata["nonlinear"]) for f in fields(cls) if "nonlinear" in f.metadata)

    @classmethod
    def units(cls) -> dict[str, str]:
        """The units of its parameters by name, amplitudes first."""
        inner = {each.name: each.unit for each in cls.nonlinear_parameters()}
        return {each.name: each.unit for each in cls.amplitudes()} | inner


@final
@dataclass(frozen=True)
class CarryOver:
    """An effect in another run than the one that it was found in."""

    effect: Effect | None  # as it acts there; None: it is left out
    doubt: str = ""  # why it is left out, or what is unknown of it there; "" for nothing
    assumption: str = ""  # the condition for the size of the doubt, such as "On a tilted surface"; may be empty
    # Other ways in which it may act there, None for not at all. How far these move points, compared with `effect`, is
    # the size of the doubt.
    alternatives: tuple[Effect | None, ...] = ()

    @classmethod
    def of(cls, effect: Effect, run: Run, found_in: RunSummary | None) -> "CarryOver":
        """An effect in the run that it was found in, or in another one, as `continued` gives it."""
        as_found = run.course is None and not effect.hindrance(run)
        return cls(effect) if as_found else effect.carried_to(run, found_in)


@final
@dataclass(frozen=True)
class CandidateEffect:
    """An effect at a location, its parameters still open."""

    effect: type[Effect]
    where: str

    def __str__(self) -> str:
        return f"{self.effect.name} at {self.where}"

    @property
    def clause(self) -> str:
        """A clause that states it in a sentence; at one of several sensors, with the sensor's name."""
        clause = (self.effect.clause or "{where}: {title}").format(where=self.where, title=self.effect.title)
        return f"{clause} ({self.where.rpartition('.')[0]})" if of_sensor(self.where) else clause

    @property
    def remedy(self) -> str:
        """Its remedy, with its location."""
        return self.effect.remedy.format(where=self.where)

    @cached_property
    def parameters(self) -> Parameters:
        """Its parameters, named `effect.where.parameter`: amplitudes, then nonlinear ones."""
        amplitudes = [
            Parameter(self.key(each.name), each.unit, 0.0, each.lower, each.bound) for each in self.effect.amplitudes()
        ]
        inner = [each.renamed(self.key(each.name)) for each in self.effect.nonlinear_parameters()]
        return Parameters((*amplitudes, *inner))

    def parameters_in(self, robot: Robot | None) -> Parameters:
        """The same in an arm: an angle at a revolute joint is a length at a prismatic one."""
        if robot is None or self.effect.stage is not Stage.JOINTS or self.where not in robot.joints:
            return self.parameters
        if not robot.prismatic[robot.joints.index(self.where)]:
            return self.parameters
        return Parameters(
            tuple(replace(each, unit=WHERE_SLIDING.get(each.unit, each.unit)) for each in self.parameters.items)
        )

    def key(self, parameter: str) -> str:
        """The name of one of its parameters among a model's parameters."""
        return f"{self.effect.name}.{self.where}.{parameter}"

    def at(self, values: Values) -> Effect:
        """The effect with the values of each candidate."""
        return self.effect(where=self.where, **{name: values[key] for name, key in self._keys.items()})

    @cached_property
    def _keys(self) -> dict[str, str]:
        return {name: self.key(name) for name in self.effect.units()}


def perturb_with(effects: tuple[Effect, ...], run: Run) -> Perturbation:
    """The effects of a model, each at its stage; at a shared stage they act in the order of the list."""
    steps = tuple((effect.stage_in(run.dataset), partial(_acted, effect, run)) for effect in effects)
    of_run = [act for effect, (_, act) in zip(effects, steps, strict=True) if effect.depends_on_trajectory]
    return Perturbation(steps, of_run)


def _acted(effect: Effect, run: Run, value: Array) -> Array:
    """The value with an effect; of several sensors' rows, only in those that can have it."""
    if not is_dual(value) and any(map(is_dual, vars(effect).values())):
        out = effect.apply(cast("Array", Dual.constant(value)), run)  # so that it can write into a copy
    else:
        out = effect.apply(value, run)
    if effect.stage not in OF_ROWS or len(run.dataset.sensors) == 1:
        return out
    if value.shape[1] == 1 and not of_sensor(effect.where):
        return out
    key = type(effect), effect.where
    if key not in run.untouched:
        run.untouched[key] = _untouched(effect, run.dataset)
    untouched = run.untouched[key]
    return np.where(untouched[:, None], value, out) if untouched.any() else out


def _untouched(effect: Effect, dataset: Dataset) -> Bools:
    """Rows of sensors that cannot have an effect, or are elsewhere, (m,)."""
    lacks = np.array([bool(len(part.points)) and bool(effect.missing(part)) for part in parts_with_lens(dataset)])
    if of_sensor(effect.where):
        lacks |= ~sensors_at(effect.where, dataset)
    return np.asarray(lacks[dataset.sensor_of_row])
