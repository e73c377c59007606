"""A sensor: its parameters, its rows of residuals, their unit and errors, and its measurements at new poses."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.sensor_format import SensorFormat
from robolaser.data.sessions import ON_FLANGE, OWN, STANDING, matches
from robolaser.errors import DataError
from robolaser.geometry.rigid_motion import carry, inverse, pose
from robolaser.model.error_source import ErrorSource
from robolaser.model.sensors.in_cell import InCell, is_static
from robolaser.model.sensors.placements import vector
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Parameter, Values

__all__ = ["NewPoses", "Perturbation", "Sensor", "SensorParameters", "Stage", "Values"]  # what sensors are written with

Seen = tuple[Points, Bools] | None
"""Rows pose by pose, the same number of each, numbered from 0; and which poses see all of theirs, (p,)."""


@final
@dataclass(frozen=True)
class SensorParameters:
    """Names of the parameters, and prior knowledge of them.

    Attributes:
        free: Parameters whose nominal values and bounds the data set gives; none where all follow from the data.
        derived: Parameters that `initialize` finds from the others; the data set may leave them out.
        fixed: Those that stay at their nominal values because the model has a freedom that no data can fix.
        fix_gauge: Converts values (c,) by name to those of an equivalent model for any data, with the fixed parameters
            at their nominal values.
        closed_form: Source from which `initialize` finds missing free parameters: "the board's corners"; "" where the
            data set must give them.
        spans: How far parameters may be from their closed-form start values, by name, from all values; others a metre
            or half a turn.
        two_axes: Whether the flange must turn about two axes for any fit to find them: unknown placements at both ends
            of the arm, A X = Z B.
        linear: Free parameters that `solve` finds from the other free ones: searches need only the latter.
        solve: From all values, T_base_flange (c or 1, n, 4, 4), the effects of the model and all parameters by name to
            the linear and the derived parameters that fit best with the others, (c,) each; the model is linearized
            where the values have them.
    """

    free: tuple[str, ...] = ()
    derived: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    fix_gauge: Callable[[Values], Values] = lambda values: values
    closed_form: str = ""
    spans: Callable[[Mapping[str, float]], Mapping[str, float]] = lambda values: {}
    two_axes: bool = False
    linear: tuple[str, ...] = ()
    solve: Callable[[Values, Array, Perturbation, Mapping[str, Parameter]], Values] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """All of them."""
        return self.free + self.derived


@final
@dataclass(frozen=True, eq=False)
class NewPoses:
    """Measurements at new poses, for plans of poses and cross-validation.

    Attributes:
        seen_from: Measurements at planned poses, from all parameters and T_base_flange (p, 4, 4); None where the
            flange cannot go elsewhere.
        aims: Likewise points on the flange, (a, 3), and where each must be for something to be seen; None for
            anywhere.
        fold_groups: Group of each row, (m,), where cross-validation holds out more than poses together; None:
            whole poses.
        relocated: Errors of held-out rows (m, k) after a refit of the parameters that only they determine.
    """

    seen_from: Callable[[Values, Array], Seen]
    aims: Callable[[Values, Array], tuple[Array, Array] | None] = lambda values, T_base_flange: None
    fold_groups: Ints | None = None
    relocated: Callable[[Array], Array] = lambda errors: errors


def not_given(sensor: SensorFormat, missing: Sequence[str], otherwise: str = "") -> DataError:
    """The error of missing free parameters, and what to do otherwise."""
    return DataError(
        f"dataset.toml, [parameters] lacks {', '.join(missing)}: a {sensor.kind} sensor needs "
        f"{{ nominal, lower, upper }} for each.{otherwise}",
        file="dataset.toml",
        column="[parameters]",
    )


def each_once(points: Points, poses: int) -> Points:
    """Rows with every named point once in each of some poses."""
    _, first = np.unique(points.number, return_index=True)
    rows = points.take(np.tile(np.sort(first), poses))
    return replace(rows, pose=np.repeat(np.arange(poses), len(first)), repeat=None)


REGISTERED: dict[str, "type[Sensor]"] = {}  # by kind; a subclass enters itself, in place of an earlier one of its name


class Sensor(ABC):
    """A sensor of one data set. A subclass is one kind of `[sensor]`; defining it registers it.

    A row of residuals has k numbers, `format.numbers`: a point in space three in metres, a camera's corner two in
    pixels. Estimation and diagnosis use whitened numbers; metres are for people.

    `format`, `parameters`, `residuals` and `row_errors` must be written; `stages`, `initialize`, `in_metres`, `known`,
    `in_cell` and `new_poses` are optional. The rest follows from them and is final.

    Attributes:
        format: Its name, what it needs in a data set, and the numbers of a row with their unit.
        stages: The stages of its values; effects at other stages do not apply.
    """

    format: ClassVar[SensorFormat]
    stages: ClassVar[frozenset[Stage]] = frozenset({Stage.JOINTS, Stage.LINKS, Stage.FLANGE})

    def __init_subclass__(cls, *, registered: bool = True) -> None:
        super().__init_subclass__()
        if registered and "format" in cls.__dict__:
            REGISTERED[cls.format.kind] = cls

    def __init__(self, dataset: Dataset) -> None:
        self.dataset = dataset

    def __reduce__(self) -> tuple[type["Sensor"], tuple[Dataset]]:
        """The arguments of a copy: results cached from the data have functions, which cannot be pickled."""
        return type(self), (self.dataset,)

    @final
    @classmethod
    def has_laser_plane(cls) -> bool:
        """Whether its points are intersections of camera rays with a laser plane: images show a stripe."""
        return Stage.LASER_PLANE in cls.stages

    @final
    @classmethod
    def stages_in(cls, dataset: Dataset) -> frozenset[Stage]:
        """The `stages` that values pass in a data set: balls on the flange have no common mount."""
        return cls.stages - {Stage.MOUNT} if cls.format.balls and is_static(dataset) else cls.stages

    @final
    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the points that it sees, in the order of `Points.number`."""
        return tuple(dict.fromkeys(self.dataset.points.names))

    @property
    @abstractmethod
    def parameters(self) -> SensorParameters:
        """Parameters that must be given, that follow from the data, and that no data can determine."""

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """Initial values of the derived parameters, for each candidate, as (c,) by name.

        Args:
            values: The free parameters; derived ones among them are known too. Where the parameters have a
                `closed_form`, free ones may be missing from a single candidate, and are to be found as well.
            T_base_flange: (c or 1, n, 4, 4).
            perturb: The effects of the model.

        Raises:
            DataError: There is no closed form for a missing one.
            EstimationError: The data do not determine them.
        """
        if self.parameters.derived:
            raise NotImplementedError(
                f"{type(self).__name__} has derived parameters, but does not define `initialize`."
            )
        return {}

    @abstractmethod
    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Measured or known less predicted, (c, m, k) [`format.unit`]; not finite at the model's poles.

        Args:
            values: All parameters, (c,) each.
            T_base_flange: (c or 1, n, 4, 4).
            perturb: The effects of the model.
        """

    @abstractmethod
    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """Noise sources of single rows, at one candidate; errors of whole poses are added for every sensor."""

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Residuals (c, m, k) in metres at the point, (c, m, j); linear, as pixels by depth over focal length."""
        return residuals

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Known or measured position of each row's point, (c, m, 3) [m]; None if a row is not a point.

        A row of three numbers in metres is that position less the predicted one.
        """
        return None

    def in_cell(self, values: Values, perturb: Perturbation) -> InCell:
        """Positions of its parts, one candidate: by default points `tool.NAME` as `tool_NAME` on the flange."""
        tools = dict.fromkeys(name.rpartition(".")[0] for name in values if name.startswith("tool."))
        return InCell({tool.replace(".", "_", 1): pose(np.eye(3), vector(values, tool)[0]) for tool in tools})

    @property
    def new_poses(self) -> NewPoses:
        """Its measurements at new poses: by default each named point once, from everywhere."""
        return NewPoses(lambda _, T: (each_once(self.dataset.points, len(T)), np.ones(len(T), dtype=bool)))

    @final
    def ranges(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Distance of each row's point from camera or tracker, one candidate, (m,) [m]; None where there is none."""
        seen = self._from_sensor(values, T_base_flange, perturb)
        return None if seen is None else np.asarray(np.linalg.norm(seen, axis=-1))

    @final
    def in_view(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Bools:
        """Whether each row's known point is in front of the camera, if there is one, one candidate, (m,)."""
        seen = None if self.format.tracker else self._from_sensor(values, T_base_flange, perturb)
        return np.ones(len(self.dataset.points), dtype=bool) if seen is None else np.asarray(seen[:, 2] > 0.0)

    def _from_sensor(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array | None:
        """Known points in the frame of the camera or tracker, one candidate, (m, 3) [m]; None where there is none."""
        known, here = self.known(values, T_base_flange, perturb), self.in_cell(values, perturb)
        if known is None or self.format.tracker:
            return None if known is None else known[0]
        T = here.stand if here.mount is None else T_base_flange @ here.mount
        if here.camera is None or T is None:
            return None
        return np.asarray(carry(inverse(T), self.dataset.points.pose, known)[0])

    @final
    @property
    def description(self) -> dict[str, Any]:
        """Its entries of calibration.json under `model`, besides its kind: its keys of `[sensor]` and `[scanner]`."""
        dataset = self.dataset
        options = {} if dataset.options is None else asdict(dataset.options)
        if "scanner" in self.format.tables:
            bracket = list(dataset.bracket_quat)
            options |= {"stripe_axis": dataset.stripe_axis, "bracket_quat": bracket, "angles": dataset.angles}
        return options

    @final
    @property
    def setup_parameters(self) -> tuple[str, ...]:
        """Its parameters of placements and mounts, which differ between campaigns."""
        patterns = (*OWN, ON_FLANGE, STANDING) if is_static(self.dataset) else (*OWN, ON_FLANGE)
        return tuple(name for name in self.parameters.names if matches(name, patterns))
