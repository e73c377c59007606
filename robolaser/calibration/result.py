"""The result of a calibration, and calibration.json."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.calibration.checks import setup_warning
from robolaser.calibration.pymoo_search import History
from robolaser.calibration.saved import CALIBRATION
from robolaser.errors import UsageError, near
from robolaser.estimation.folds import FoldFits
from robolaser.estimation.identifiability import Unidentifiable
from robolaser.estimation.noise_weighted_fit import NoiseWeightedFit
from robolaser.model.blocks.cell_frames import in_cell
from robolaser.model.effects.run import RunSummary
from robolaser.model.forward_model import Model
from robolaser.model.sensors.in_cell import InCell
from robolaser.parameters import Parameter, Values
from robolaser.robot.kinematics import Robot

DISTANCES = "distances"


@final
@dataclass(frozen=True)
class RowErrors:
    """The errors of one kind of rows, in their own unit."""

    sensor: str  # the sensor's kind, of several its name, or `distances`
    rows: int  # how many rows there are
    rms: float  # root-mean-square length of a fitted row's residual
    held_out_rms: float | None  # on poses held out; None with too few, and for distances, which belong to no pose
    unit: str  # "m", "px" …


@final
@dataclass(frozen=True)
class Calibration:
    """The parameters estimated from data, with their uncertainty and errors.

    Attributes:
        model: The data set and the effects in the model.
        algorithm: Name of the global search.
        weights: "plain" or "noise".
        seed: Seed of the search.
        x: The parameters in the order of `model.parameters`, (d,).
        std: One standard deviation of each, (d,); NaN where it is fixed or not identifiable.
        on_bound: Parameters that ended on one of their bounds, (d,).
        unidentifiable: Groups of parameters that the data cannot separate.
        residuals: Known or measured minus predicted, in the sensor's unit, (m, k).
        held_out: Errors on poses held out of the fit, at the points, (m', j) [m]; None with too few poses. One for
            each fitted row: all rows, or those in `weighted`.
        noise: Standard deviation of each source of noise, stated or estimated.
        history: The progress of the global search; None without one.
        evaluations: Candidates evaluated in all.
        seconds: Time taken, where it was measured.
        warnings: Warnings for the user.
        unseen: Fits without each fold, and their predictions of the fitted rows; None where they were not kept.
        fitted: The model of the fitted rows; None where these are all.
        weighted: Their weights by noise; None for equal weights, and where they were not kept.

    Examples:
        >>> robolaser.calibrate(dataset).calibration.value("f")
        0.008
    """

    model: Model
    algorithm: str
    weights: str
    seed: int
    x: Array
    std: Array
    on_bound: Bools
    unidentifiable: tuple[Unidentifiable, ...]
    residuals: Array
    held_out: Array | None
    noise: Mapping[str, float]
    history: History | None
    evaluations: int
    warnings: tuple[str, ...]
    seconds: float = 0.0
    unseen: FoldFits | None = None
    fitted: Model | None = None
    weighted: NoiseWeightedFit | None = None

    @cached_property
    def values(self) -> Values:
        """The parameters by name, (1,) each."""
        return self.model.parameters.values(self.x[None])

    @property
    def undetermined_effects(self) -> tuple[str, ...]:
        """Parameters of effects that the data cannot identify, unless the gauge does, and those on a bound."""
        names, groups = self.model.parameters.names, (group.parameters for group in self.unidentifiable)
        unclear = {name for group in groups if not {*self.model.blocks.fixed} & {*group} for name in group}
        unclear |= {name for name, at in zip(names, self.on_bound, strict=True) if at}
        return tuple(name for name in self.model.effect_parameters.names if name in unclear)

    @property
    def in_cell(self) -> InCell:
        """The sensors in the cell."""
        return in_cell(self.model.blocks, self.values, self.model.perturb(self.values))

    @cached_property
    def objective_m2(self) -> float:
        """J of eq. 18: the sum of squared residuals, in the square of the sensor's unit; without angles."""
        blocks = self.model.blocks
        numbers = blocks.row_numbers.copy()
        for rows, _, angles in blocks.kinds_of_rows.values():
            numbers[rows] -= angles
        lengths = np.arange(self.residuals.shape[1]) < numbers[:, None]
        return float((self.residuals[lengths] ** 2).sum())

    @cached_property
    def errors_m(self) -> Array:
        """The residuals at the points, (m, j) [m]."""
        return self.model.in_metres(self.x, self.residuals)

    @property
    def fitted_model(self) -> Model:
        """The model of the fitted rows."""
        return self.model if self.fitted is None else self.fitted

    @cached_property
    def robot(self) -> Robot | None:
        """The corrected arm, as the exported URDF has it: `forward`, `jacobian` and `inverse`, in batches.

        With the offsets and placements of joints in the model. Effects that no URDF can represent, such as joint
        compliance, are not in it. None for a data set of measured flange poses.
        """
        return self.model.robot_at(self.x)

    @cached_property
    def rms_m(self) -> float:
        """Root-mean-square 3-D error of the calibration points."""
        return rms(self.errors_m)

    @property
    def setup_warning(self) -> str | None:
        """A warning that start values, bounds, axes or units seem to be wrong; None without evidence."""
        return setup_warning(self.model, self.on_bound, self.rms_m)

    @cached_property
    def held_out_rms_m(self) -> float | None:
        """The same on poses held out of the fit."""
        return None if self.held_out is None else rms(self.held_out)

    @cached_property
    def row_errors(self) -> tuple[RowErrors, ...]:
        """The errors of the sensor's rows, of angles separately, then of the known distances, if any are stated."""
        blocks, known = self.model.blocks, self.model.known_distances
        of_sensors = [errors for name, kind in blocks.kinds_of_rows.items() for errors in self._of_rows(name, *kind)]
        if known is None:
            return tuple(of_sensors)
        apart = known.residuals(self.values)[0]
        return *of_sensors, RowErrors(DISTANCES, len(known), rms(apart[:, None]), None, "m")

    def _of_rows(self, name: str, rows: Ints, unit: str, angles: int) -> Iterator[RowErrors]:
        """The errors of one sensor's rows, and of their angles."""
        blocks, held_out = self.model.blocks, self.unseen and self.unseen.errors
        if held_out is None and self.held_out is not None and unit == "m" and len(rows) == len(self.residuals):
            held_out = None if angles else self.held_out
        fitted = blocks.own_rows(self.residuals, name)
        unseen = None if held_out is None else self.fitted_model.blocks.own_rows(held_out, name)
        lengths = slice(fitted.shape[1] - angles)
        for part, of_part in ((lengths, unit), (slice(lengths.stop, None), "rad")):
            if fitted[:, part].size:
                rms_unseen = None if unseen is None else rms(unseen[:, part])
                yield RowErrors(name, len(rows), rms(fitted[:, part]), rms_unseen, of_part)

    def value(self, name: str) -> float:
        """The estimated value of a parameter.

        Raises:
            UsageError: There is no parameter of that name.
        """
        names = self.model.parameters.names
        if name not in names:
            raise UsageError(f"No parameter '{name}'.{near(name, names)}")
        return float(self.x[names.index(name)])


def rms(errors: Array) -> float:
    """Root-mean-square length of errors (m, j)."""
    return float(np.sqrt((errors**2).sum(axis=-1).mean()))


def rms_of_poses(errors: Array, pose: Ints, count: int) -> Array:
    """The same for each pose, from errors (m, j) and pose numbers (m,): (count,) [m]; NaN without rows."""
    rows = np.bincount(pose, minlength=count)
    sums = np.bincount(pose, np.square(errors).sum(axis=-1), minlength=count)
    return np.asarray(np.sqrt(np.divide(sums, rows, out=np.full(count, np.nan), where=rows > 0)))


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _entry(parameter: Parameter, value: float, std: float) -> dict[str, Any]:
    entry: dict[str, Any] = {"value": float(value), "std": _number(std), "unit": parameter.unit}
    given = (parameter.nominal, parameter.lower, parameter.upper) if parameter.given else (None, None, None)
    start: dict[str, Any] = {"start": float(parameter.nominal)}
    if not parameter.given and parameter.origin:
        start["started_from"] = parameter.origin
    return entry | dict(zip(("nominal", "lower", "upper"), given, strict=True)) | start


def _effect_entries(calibration: Calibration) -> Sequence[dict[str, Any]]:
    names, robot = calibration.model.parameters.names, calibration.model.dataset.robot
    out = []
    for candidate_effect in calibration.model.effects:
        numbers = {}
        for parameter in candidate_effect.parameters_in(robot).items:
            i = names.index(parameter.name)
            numbers[parameter.name.rsplit(".", 1)[-1]] = {
                "value": float(calibration.x[i]),
                "std": _number(calibration.std[i]),
                "unit": parameter.unit,
            }
        out.append({"effect": candidate_effect.effect.name, "where": candidate_effect.where, "parameters": numbers})
    return out


def as_json(calibration: Calibration) -> dict[str, Any]:
    """The contents of calibration.json: format `robolaser-calibration/1`."""
    dataset, model = calibration.model.dataset, calibration.model
    robot = dataset.robot
    sensor = len(model.parameters) - len(model.effect_parameters)
    items = zip(model.parameters.items[:sensor], calibration.x, calibration.std, strict=False)
    description = {
        "sensor": dataset.kind,
        **model.blocks.description,
        "robot": "robot.urdf" if robot else None,
        "flange": robot.flange if robot else None,
        "joints": list(robot.joints) if robot else None,
        "gravity": list(robot.gravity) if robot else None,
        "image": list(dataset.image_px) if dataset.image_px else None,
    }
    is_in_metres = all(unit == "m" for _, unit, _ in model.blocks.kinds_of_rows.values())
    return {
        "format": CALIBRATION,
        "dataset": dataset.name,
        "algorithm": calibration.algorithm,
        "seed": calibration.seed,
        "weights": calibration.weights,
        "parameters": {item.name: _entry(item, value, std) for item, value, std in items},
        "unidentifiable": [{"parameters": list(u.parameters), "reason": u.reason} for u in calibration.unidentifiable],
        "model": description,
        "effects": _effect_entries(calibration),
        "run": asdict(RunSummary.of(dataset)),
        "objective_m2": calibration.objective_m2 if is_in_metres else None,
        "rms_m": calibration.rms_m,
        "max_m": float(np.linalg.norm(calibration.errors_m, axis=-1).max()),
        "axis_max_m": [float(a) for a in np.abs(calibration.errors_m).max(axis=0)],
        "held_out_rms_m": calibration.held_out_rms_m,
        "rows": [asdict(errors) for errors in calibration.row_errors],
        "noise": {name: float(sigma) for name, sigma in calibration.noise.items()},
        "warnings": list(calibration.warnings),
        "evaluations": calibration.evaluations,
        "seconds": round(calibration.seconds, 3),
    }
