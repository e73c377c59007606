"""The model of a cell: the chain from encoder and image to points, with effects at its stages."""

import shlex
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import cast, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.duals import Dual, slopes_of
from robolaser.errors import DataError
from robolaser.model.blocks.blocks import Blocks, KnownDistances
from robolaser.model.blocks.start import initialize, parameters_of
from robolaser.model.effects.effect import CandidateEffect, Run, perturb_with
from robolaser.model.effects.run import Course
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Parameters, Values
from robolaser.robot.kinematics import Robot

STARTED = "_started"
CHUNK = 400_000  # point-evaluations at a time: their residuals still fit into a processor's cache
ROWS = 6_000  # number of rows at which a batch ends: their derivatives by some ten parameters fit a processor's cache


def started(dataset: Dataset) -> Dataset:
    """A data set with closed forms for the free parameters that it does not give; itself if it gives all.

    Raises:
        DataError: There is no closed form for a missing one.
        EstimationError: The data do not determine it.
    """
    known: Dataset | None = dataset.__dict__.get(STARTED)
    if known is None:
        known = _started(dataset) if len(dataset.points) else dataset
        dataset.__dict__[STARTED] = known.__dict__[STARTED] = known
    return known


def _started(dataset: Dataset) -> Dataset:
    blocks = Blocks(dataset)
    missing = [name for name in blocks.free if name not in blocks.given]
    if not missing:
        return dataset
    found = {item.name: item for item in parameters_of(blocks, dataset.flange()[None]).items}
    return replace(dataset, parameters={**dataset.parameters, **{name: found[name] for name in missing}})


@final
@dataclass(frozen=True, eq=False)
class Model:
    """A data set seen through the nominal model and the effects added to it."""

    dataset: Dataset  # what was measured
    effects: tuple[CandidateEffect, ...] = ()  # effects that are in the model; those at one stage act in this order
    course: Course | None = None  # progress of the run, where that does not start at zero

    def __post_init__(self) -> None:
        object.__setattr__(self, "dataset", started(self.dataset))
        if not len(self.dataset.points):
            folder = self.dataset.folder
            command = shlex.join(["robolaser", "extract", str(folder)])
            raise DataError(
                f"{folder} has no points.csv yet. Run `{command}` first, or measure points."
                if folder and not (folder / "points.csv").exists()
                else "There are no points, no rows of points.csv: there is nothing to calibrate from.",
                file="points.csv",
            )

    @cached_property
    def blocks(self) -> Blocks:
        """The rows of every sensor in every session."""
        return Blocks(self.dataset)

    @cached_property
    def run(self) -> Run:
        """The data that effects may use."""
        return Run(self.dataset, self.course)

    def with_effects(self, candidate_effects: tuple[CandidateEffect, ...]) -> "Model":
        """The same data with other effects; results for the data alone are kept."""
        other = Model(self.dataset, candidate_effects, self.course)
        other.__dict__.update(blocks=self.blocks, run=self.run, _nominal_flange=self._nominal_flange)
        return other.sharing(self.sensor_parameters)

    def sharing(self, sensor_parameters: Parameters) -> "Model":
        """The same with the sensor's parameters of another model of more data, so that closed forms are of all."""
        other = Model(self.dataset, self.effects, self.course)
        other.__dict__.update(self.__dict__, sensor_parameters=sensor_parameters)
        other.__dict__.pop("parameters", None)
        return other

    @cached_property
    def effect_parameters(self) -> Parameters:
        """The numbers of the effects."""
        robot = self.dataset.robot
        return sum((effect.parameters_in(robot) for effect in self.effects), start=Parameters(()))

    @cached_property
    def parameters(self) -> Parameters:
        """The sensor's parameters, then those of the effects."""
        return self.sensor_parameters + self.effect_parameters

    @cached_property
    def sensor_parameters(self) -> Parameters:
        """The sensor's parameters; effects at their nominal values change none of them."""
        return parameters_of(self.blocks, self._nominal_flange)

    def perturb(self, values: Values) -> Perturbation:
        """The effects with the numbers of each candidate."""
        return perturb_with(tuple(candidate_effect.at(values) for candidate_effect in self.effects), self.run)

    @cached_property
    def _nominal_flange(self) -> Array:
        return self.dataset.flange()[None]

    @cached_property
    def _seen(self) -> Ints | None:
        """Poses with points; None where all have some."""
        seen = np.unique(self.dataset.points.pose)
        return None if len(seen) == len(self.dataset.poses) else seen

    def flange(
        self, values: Values, perturb: Perturbation | None = None, q: Array | None = None, *, only_seen: bool = False
    ) -> Array:
        """T_base_flange at every pose, (c or 1, n, 4, 4); with its derivatives where values carry some.

        Args:
            values: By name, (c,) each.
            perturb: The effects with these values.
            q: Joint values instead of those read, (c or 1, n, j).
            only_seen: Whether the nominal arm suffices where poses have no points: no residual needs these.
        """
        perturb = perturb or self.perturb(values)
        poses, robot, seen = self.dataset.poses, self.dataset.robot, self._seen if only_seen else None
        if robot is None or poses.q is None or (q is None and not perturb.touches(Stage.JOINTS, Stage.LINKS)):
            return perturb(Stage.FLANGE, self._nominal_flange)
        q, placements = perturb(Stage.JOINTS, poses.q[None] if q is None else q), robot.placements[None, None]
        placements = perturb(Stage.LINKS, placements)
        if seen is None:
            return perturb(Stage.FLANGE, robot.forward(q, placements))
        there = robot.forward(q[:, seen], placements if placements.shape[1] == 1 else placements[:, seen])
        flange: Array = np.zeros_like(there, shape=(len(there), *self._nominal_flange.shape[1:]))
        flange[:] = self._nominal_flange
        flange[:, seen] = there
        return perturb(Stage.FLANGE, flange)

    def _in_chunks(self, x: Array) -> Sequence[Array]:
        at_once = max(1, CHUNK // len(self.dataset.points))
        return np.array_split(x, max(1, -(-len(x) // at_once)))

    def residuals(self, x: Array) -> Array:
        """Measured or known less predicted, a row for each row of points.csv.

        Args:
            x: Candidates in the order of `parameters`, (c, d).

        Returns:
            (c, m, k) [`blocks.unit`]; not finite at the model's poles.
        """
        parts = [self.residuals_at(self.parameters.values(part)) for part in self._in_chunks(x)]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def residuals_at(self, values: Values) -> Array:
        """The same for values by name, (c,) each, all candidates at once."""
        perturb = self.perturb(values)
        return self.blocks.residuals(values, self.flange(values, perturb, only_seen=True), perturb)

    @property
    def known_distances(self) -> KnownDistances | None:
        """Additional rows of every fit beside those of points.csv, of no pose; None where there are none."""
        return self.blocks.known_distances

    def extra_residuals(self, x: Array) -> Array:
        """Known distances less the model's over their standard deviation, (c, d) -> (c, r); r may be 0.

        They are white already. A fit with rows weighted by their whole noise appends them unchanged. A fit without
        known row errors, as the plain one that minimises J, appends them times the standard deviation s of a row's
        numbers: it then minimises s² (J / s² + Σ δ²/σ²), in which both kinds of rows are weighted by their noise.
        """
        known = self.known_distances
        return np.empty((len(x), 0)) if known is None else known.residuals(self.parameters.values(x)) / known.sigma_m

    def at(self, x: Array) -> tuple[Values, Array, Perturbation]:
        """The arguments of most functions of blocks: the values of one candidate (d,), its flange, and its effects."""
        values = self.parameters.values(x[None])
        perturb = self.perturb(values)
        return values, self.flange(values, perturb), perturb

    def in_metres(self, x: Array, residuals: Array) -> Array:
        """Residuals (m, k) at x (d,) in metres at the point, (m, j), for people to read."""
        there: Array = self.blocks.in_metres(residuals[None], *self.at(x))[0]
        return there

    def completed(self, values: Values, known: Collection[str] = ()) -> Values:
        """Values with the parameters added that follow from the others in closed form, else at their nominal values.

        Args:
            values: Known values, (c,) each.
            known: Parameters that stay as in `values`, though they would follow from the others.
        """
        stay = {*known, *self.blocks.held}
        follow = [name for name in self.blocks.derived if name not in stay]
        if not follow:
            return values
        others = {name: value for name, value in values.items() if name not in follow}
        perturb = self.perturb(values)
        found = initialize(self.blocks, others, self.flange(values, perturb), perturb)
        if lost := [name for name in follow if name not in found]:
            nominal = {item.name: item.nominal for item in self.sensor_parameters.items}
            count = max(map(len, others.values()), default=1)
            found |= {name: np.full(count, nominal[name]) for name in lost}
        return {**values, **{name: found[name] for name in follow}}

    def fix_gauge(self, x: Array) -> Array:
        """An equivalent model for any data, with the fixed parameters at their nominal values, (d,)."""
        values = self.blocks.fix_gauge(self.parameters.values(x[None]))
        return np.array([values[name][0] for name in self.parameters.names])

    def robot_at(self, x: Array) -> Robot | None:
        """The arm as it is at x (d,); None without one, and the arm itself where no effect changes its URDF.

        Offsets move a joint's zero: its limits then count from the new one.
        """
        robot, values = self.dataset.robot, self.parameters.values(x[None])
        written = tuple(one.at(values) for one in self.effects if one.effect.in_urdf)
        if robot is None or not written:
            return robot
        perturb = perturb_with(written, self.run)
        offset = perturb(Stage.JOINTS, np.zeros((1, 1, len(robot.joints))))[0, 0]
        return robot.with_placements(perturb(Stage.LINKS, robot.placements[None, None])[0, 0], offset)

    def cost(self, x: Array) -> Array:
        """J of eq. 18, (c, d) -> (c,) [m²]; infinite at the model's poles."""
        with np.errstate(over="ignore", invalid="ignore"):
            parts = (self.residuals_at(self.parameters.values(part)) for part in self._in_chunks(x))
            J = np.concatenate([np.einsum("cmk,cmk->c", residuals, residuals) for residuals in parts])
        return np.where(np.isfinite(J), J, np.inf)


def jacobian(model: Model, x: Array) -> Array:
    """Derivatives of the residuals at candidates (c, d) by all parameters, (c, d, m, k), in their unit per unit.

    Effects and sensors run on duals.
    """
    values = {name: Dual.parameter(x[:, i], i) for i, name in enumerate(model.parameters.names)}
    slopes = slopes_of(model.residuals_at(cast("Values", values)), x.shape[1])
    return np.ascontiguousarray(np.swapaxes(slopes, 0, 1))


def jacobian_matrix(model: Model, x: Array) -> Array:
    """The same at one candidate (d,), for all numbers of all rows, (m k, d)."""
    J = jacobian(model, x[None])[0]
    return np.asarray(J.reshape(len(J), -1).T)


def batches_of(model: Model) -> tuple[tuple[Ints, Model], ...]:
    """A model in batches of whole poses; a single one if it is small, or if an effect depends on other poses.

    Returns:
        The numbers of some of its rows, (m,), and the model of only these and their poses, with the parameters of the
        whole.
    """
    whole = np.arange(len(model.dataset.points))
    if len(whole) <= ROWS or depends_on_trajectory(model):
        return ((whole, model),)
    return tuple(_cut(model))


def depends_on_trajectory(model: Model) -> bool:
    """Whether rows of a model depend on poses besides their own."""
    return any(candidate_effect.effect.depends_on_trajectory for candidate_effect in model.effects)


def with_rows(model: Model, rows: Ints) -> Model:
    """The model of some rows; effects that depend on the trajectory see only these and all poses."""
    return of_data(model, replace(model.dataset, points=model.dataset.points.take(rows)))


def of_data(model: Model, dataset: Dataset) -> Model:
    """The model of some of its data, which may be averaged, with the parameters of the whole."""
    return Model(dataset, model.effects, model.course).sharing(model.sensor_parameters)


def _cut(model: Model) -> Iterator[tuple[Ints, Model]]:
    dataset = model.dataset
    order = np.argsort(dataset.points.pose, kind="stable")
    counts = np.bincount(dataset.points.pose, minlength=len(dataset.poses))
    ends = np.cumsum(counts)
    begins = np.searchsorted(ends, np.arange(0, len(order), ROWS), side="right")
    poses = np.unique([*begins, len(counts)])
    for first, last in pairwise(poses.tolist()):
        rows = order[ends[first] - counts[first] : ends[last - 1]]
        if len(rows):
            points = dataset.points.take(rows)
            part = replace(
                dataset,
                poses=dataset.poses.take(np.arange(first, last)),
                points=replace(points, pose=points.pose - first),
            )
            yield rows, Model(part, model.effects).sharing(model.sensor_parameters)
