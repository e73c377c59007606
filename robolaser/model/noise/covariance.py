"""How much of a residual is measurement error: its sources, their sizes, and residuals made comparable by them."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import of_some_groups, rows_of_each, some_of_each
from robolaser.model.derivatives import jacobian_matrix
from robolaser.model.error_source import ErrorSource
from robolaser.model.forward_model import Model
from robolaser.model.noise import reml
from robolaser.model.noise.repeats import pixel_from_repeats
from robolaser.model.noise.sources import error_sources
from robolaser.model.noise.whitening import GroupStage, Whitener, group_sums
from robolaser.model.pose_blocks import depends_on_trajectory, with_rows

FLOOR = 1e-6
"""Standard deviation of every number of a row in its own unit, added to all: no covariance becomes singular."""
MOST_ROWS_A_POSE = 30  # more say nothing new on how large the errors are
MOST_ROWS = 2000  # altogether, as long as each pose keeps a few
LEAST_ROWS_A_POSE = 3
MOST_POSES = 2000
MOST_NAMES = 30  # reflectors or sockets

Origin = Literal["stated", "repeats", "estimated"]
Known = Mapping[str, tuple[float, Origin]]  # sizes of sources, and where they come from, by name


@final
@dataclass(frozen=True)
class NoiseModel:
    """The errors of a data set's rows: independent between poses, correlated within."""

    sources: tuple[ErrorSource, ...]  # what may shake the rows, see `robolaser.model.noise.sources`
    sigmas: Mapping[str, float]  # standard deviation of each source, by name, in its unit
    # where each size comes from: "stated", "repeats", or "estimated" from the residuals
    origin: Mapping[str, Origin] = field(default_factory=dict)
    relative: bool = False  # whether whitened rows are of unit variance only up to a common factor

    @property
    def estimated(self) -> tuple[str, ...]:
        """Sources whose sizes the residuals or repeats gave rather than the data set."""
        return tuple(name for name, origin in self.origin.items() if origin != "stated")

    def at(self, sigmas: Mapping[str, float]) -> "NoiseModel":
        """The same sources with other sizes; those not named keep theirs."""
        return replace(self, sigmas={**self.sigmas, **sigmas})

    def for_weights(self) -> "NoiseModel":
        """The noise that weights may rest on: all but estimated errors of whole poses.

        Those hold what the model lacks. To weigh by them would trust the model within each pose, where it fails.
        What is left tells how rows compare with each other, no longer how large their errors are.
        """
        gone = [source.name for source in self.sources if source.level == "pose" and source.name in self.estimated]
        return replace(self.at(dict.fromkeys(gone, 0.0)), relative=self.relative or bool(gone))

    def of_rows(self, rows: Ints) -> "NoiseModel":
        """The noise of some rows, whole poses of them."""
        sources = (
            replace(source, effect=source.effect[rows], group=np.unique(source.group[rows], return_inverse=True)[1])
            for source in self.sources
        )
        return replace(self, sources=tuple(sources))

    @cached_property
    def _whitener(self) -> Whitener:
        own = self._floor()
        levels: list[tuple[Array, Ints]] = []
        of_poses: list[tuple[Array, Ints]] = []
        shaking = (source for source in self.sources if self.sigmas[source.name] > 0.0)
        for source in sorted(shaking, key=lambda source: len(np.unique(source.group)), reverse=True):
            effect = self.sigmas[source.name] * source.effect
            into = of_poses if source.level == "pose" else levels
            if source.level != "pose" and len(np.unique(source.group)) == self._rows:
                own += effect @ np.swapaxes(effect, -1, -2)
            elif into and np.array_equal(into[-1][1], source.group):
                into[-1] = (np.concatenate([into[-1][0], effect], axis=-1), source.group)
            else:
                into.append((effect, source.group))
        return Whitener.of(own, [*levels, *of_poses])

    @cached_property
    def _of_poses(self) -> GroupStage | None:
        """The stage that whitens errors of whole poses, always the last one; None where there are none."""
        shaking = any(source.level == "pose" and self.sigmas[source.name] > 0.0 for source in self.sources)
        return self._whitener.stages[-1] if shaking else None

    @property
    def scatter(self) -> Array:
        """Variance that errors of whole poses add to each direction in which they move a pose, (n q,).

        In units of what is there without them; empty where there are none.
        """
        return np.zeros(0) if self._of_poses is None else self._of_poses.variances.reshape(-1)

    def scatter_squares(self, white: Array) -> Array:
        """Squares of whitened residuals (m k,) along the same directions, (n q,)."""
        rows = white.reshape(self._rows, self.numbers)
        return np.zeros(0) if self._of_poses is None else self._of_poses.squares(rows).reshape(-1)

    def with_scatter_times(self, factor: float) -> "NoiseModel":
        """The same with larger or smaller errors of whole poses."""
        return self.at({source.name: factor * self.sigmas[source.name] for source in self.sources_of_poses})

    @property
    def sources_of_poses(self) -> tuple[ErrorSource, ...]:
        """Those that shake whole poses."""
        return tuple(source for source in self.sources if source.level == "pose")

    @property
    def _rows(self) -> int:
        return len(self.sources[0].group)

    @property
    def numbers(self) -> int:
        """Numbers of a row, k."""
        return int(self.sources[0].effect.shape[1])

    def _floor(self) -> Array:
        k = self.numbers
        return np.broadcast_to(FLOOR**2 * np.eye(k), (self._rows, k, k)).copy()

    def whiten(self, residuals: Array) -> Array:
        """Make residuals independent and of unit variance, (c, m, k) or (c, m k) [row's unit] -> (c, m k)."""
        return self._whitener(residuals)

    def weigh(self, white: Array) -> Array:
        """Σ⁻¹ times residuals that are white already, (c, m k) -> (c, m k) [1/row's unit]."""
        return self._whitener.back(white)

    def correlate(self, white: Array) -> Array:
        """Undo `whiten`: residuals whose whitened ones are given, (c, m k) -> (c, m k) [row's unit]."""
        weighed = self.weigh(white)
        rows = weighed.reshape(len(white), self._rows, self.numbers).transpose(1, 2, 0)
        total: Array = FLOOR**2 * rows
        for source in self.sources:
            moved = rows if source.isotropic else np.swapaxes(source.effect, -1, -2) @ rows
            shared = self.sigmas[source.name] ** 2 * group_sums(moved, source.group)[source.group]
            total = total + (shared if source.isotropic else source.effect @ shared)
        return total.transpose(2, 0, 1).reshape(white.shape)

    def seen_through(self, J: Array) -> Array:
        """JᵀΣJ for a Jacobian (m k, d), -> (d, d)."""
        d = J.shape[1]
        rows = J.reshape(self._rows, self.numbers, d)
        total: Array = FLOOR**2 * (J.T @ J)
        for source in self.sources:
            moved = rows if source.isotropic else np.swapaxes(source.effect, -1, -2) @ rows
            shared = self.sigmas[source.name] * group_sums(moved, source.group).reshape(-1, d)
            total = total + shared.T @ shared
        return total

    @cached_property
    def covariances(self) -> Array:
        """Covariance of each row by itself, all sources together, (m, k, k) [row's unit²]."""
        total = self._floor()
        for source in self.sources:
            effect = self.sigmas[source.name] * source.effect
            total += effect @ np.swapaxes(effect, -1, -2)
        return total

    def draw(self, count: int, rng: np.random.Generator) -> Array:
        """Errors as this noise would make them, (count, m, k) [row's unit]."""
        e = FLOOR * rng.standard_normal((count, self._rows, self.numbers))
        for source in self.sources:
            unit = rng.standard_normal((count, int(source.group.max()) + 1, source.effect.shape[-1]))
            e += self.sigmas[source.name] * np.einsum("mkq,cmq->cmk", source.effect, unit[:, source.group])
        return e


def noise_of(model: Model, x: Array, kept: Bools | None = None) -> NoiseModel:
    """The noise of a data set, judged at the optimum.

    Parameters on a bound are taken as not fitted: what they could not mend is left in the residuals.

    Args:
        model: The model that was fitted.
        x: The optimum, (d,).
        kept: Rows to judge by, (m,); all when absent.
    """
    sizes = sizes_of(model, x, kept)
    return sizes if sizes._rows == len(model.dataset.points) else replace(sizes, sources=error_sources(model, x))


def sizes_of(model: Model, x: Array, kept: Bools | None = None) -> NoiseModel:
    """As `noise_of`, of no more rows than the sizes are judged by."""
    some = _telling(model, kept)
    inside = (x > model.parameters.lower) & (x < model.parameters.upper)
    J = jacobian_matrix(some, x)[:, inside]
    sources = error_sources(some, x)
    likelihood = NoiseLikelihood(sources, some.dataset.points.pose, some.residuals(x[None])[0], J)
    return likelihood.likeliest(known_sizes(sources, model.dataset))[0]


def _telling(model: Model, kept: Bools | None) -> Model:
    """The model of rows that tell the sizes of errors: more poses, or more rows of each, say nothing new."""
    points = model.dataset.points
    rows = np.arange(len(points)) if kept is None else np.flatnonzero(kept)
    if model.blocks.prefix_of(points.names[0]):  # each name is a place of its own to be fitted
        rows = rows[of_some_groups(points.number[rows], MOST_NAMES)]
    rows = rows[of_some_groups(points.pose[rows], MOST_POSES)]
    rows = rows[rows_of_each(points.pose[rows], _most_of_a_pose(len(np.unique(points.pose[rows]))))]
    return model if len(rows) == len(points) or depends_on_trajectory(model) else with_rows(model, rows)


def noise_from(dataset: Dataset, sources: tuple[ErrorSource, ...], residuals: Array, J: Array) -> NoiseModel:
    """The sizes of the sources, from what is stated, from repeats and from the residuals of a fit.

    What `[noise]` states is taken as it is. The pixels' comes from repeats where there are enough. The rest is
    estimated from the residuals by restricted maximum likelihood; at the level of the pose there is always a source
    left for it, so that residuals larger than the stated noise are not passed over.

    Args:
        dataset: Repeats, and which rows make a pose.
        sources: What may shake the rows, and how much where that is stated.
        residuals: What the fit left over, (m, k) [row's unit].
        J: The residuals by the parameters that were fitted, (m k, d).
    """
    likelihood = NoiseLikelihood(sources, dataset.points.pose, residuals, J)
    return likelihood.likeliest(known_sizes(sources, dataset))[0]


def known_sizes(sources: tuple[ErrorSource, ...], shots: Dataset) -> dict[str, tuple[float, Origin]]:
    """The sizes of sources that the data set states, and of its pixels as repeats have them, if nobody states them.

    Args:
        sources: What may shake the rows.
        shots: The data set with its repeats.
    """
    known: dict[str, tuple[float, Origin]] = {
        source.name: (source.stated, "stated") for source in sources if source.stated is not None
    }
    unstated = {source.name for source in sources if source.stated is None}
    for prefix, part in shots.named_parts:
        name = f"{prefix}pixel"
        pixel = pixel_from_repeats(part) if name in unstated else None
        if pixel is not None:
            known[name] = pixel, "repeats"
    return known


@final
@dataclass(frozen=True, eq=False)
class NoiseLikelihood:
    """How likely sizes of the sources make the residuals that a fit left over."""

    sources: tuple[ErrorSource, ...]  # what may shake the rows
    of_pose: Ints  # pose of each row, (m,)
    residuals: Array  # what the fit left over, (m, k) [row's unit]
    J: Array  # the residuals by the parameters that were fitted, (m k, d)

    def likeliest(self, known: Known, least: Mapping[str, float] | None = None) -> tuple[NoiseModel, float]:
        """The noise with the sizes that are known (see `known_sizes`), and with the likeliest of the others.

        Args:
            known: By name.
            least: What others cannot be below, by name; what their source says when absent.

        Returns:
            The noise, and the negative log of the restricted likelihood, up to a constant of the rows.
        """
        sigmas, cost = {name: size for name, (size, _) in known.items()}, 0.0
        if unknown := [source for source in self.sources if source.name not in known]:
            low = np.array([(least or {}).get(source.name, source.least) for source in unknown])
            unit = [self._unit[source.name] for source in unknown]
            high = np.array([source.most for source in unknown])
            found, cost = reml.estimate(self._covariance(sigmas), unit, *self._rows, low, high)
            sigmas |= dict(zip([source.name for source in unknown], found.tolist(), strict=True))
        names = [source.name for source in self.sources]
        origin: dict[str, Origin] = {name: known[name][1] if name in known else "estimated" for name in names}
        return NoiseModel(self.sources, {name: sigmas[name] for name in names}, origin), cost

    def gain_of_growth(self, noise: NoiseModel, names: Collection[str]) -> float:
        """By how much the likelihood's logarithm would rise if the sizes of some sources grew, by a score test.

        Args:
            noise: The likeliest with these sizes.
            names: Of these sources.
        """
        shaking, (_, expected, there, curvature) = self._restricted(noise)
        tried = np.isin(shaking, list(names))
        slope = np.where(tried, there - expected, 0.0)
        free = ~tried | (slope > 0.0)
        return 0.5 * float(slope[free] @ np.linalg.lstsq(curvature[np.ix_(free, free)], slope[free])[0])

    def cost(self, noise: NoiseModel) -> tuple[float, dict[str, float]]:
        """The negative log of the restricted likelihood of some noise, and the relative error of each size by name.

        The value is up to a constant of the rows; the errors are standard deviations of the sizes' logarithms.
        """
        shaking, (value, _, _, curvature) = self._restricted(noise)
        errors = np.sqrt(np.maximum(np.diag(np.linalg.pinv(curvature)), 0.0))
        return value, dict(zip(shaking, errors.tolist(), strict=True))

    def _restricted(self, noise: NoiseModel) -> tuple[list[str], tuple[float, Array, Array, Array]]:
        """Names of the sources that shake, and `reml.restricted` of their sizes."""
        shaking = {name: size for name, size in noise.sigmas.items() if size > 0.0}
        unit, log_sigma = [self._unit[name] for name in shaking], np.log(list(shaking.values()))
        return list(shaking), reml.restricted(log_sigma, self._covariance({}), unit, *self._rows)

    @cached_property
    def _table(self) -> Ints:
        """Rows of each pose that count, (n, r); -1 where a pose has fewer."""
        return some_of_each(self.of_pose, _most_of_a_pose(len(np.unique(self.of_pose))))

    @cached_property
    def _is_row(self) -> Bools:
        """Whether a pose has this number, (n, s)."""
        return np.repeat(self._table >= 0, self.residuals.shape[-1], axis=1)

    @cached_property
    def _unit(self) -> dict[str, Array]:
        """Covariance that a unit of each source causes within each pose, (n, s, s)."""
        return {source.name: reml.blocks(source.effect, source.group, self._table) for source in self.sources}

    @cached_property
    def _rows(self) -> tuple[Array, Array]:
        """The residuals of each pose (n, s), and a basis of what the fitted numbers can do to them (n, s, d)."""
        k = self.residuals.shape[-1]
        columns = (k * self._table[:, :, None] + np.arange(k)).reshape(self._is_row.shape)
        e = np.where(self._is_row, self.residuals.reshape(-1)[columns], 0.0)
        return e, reml.basis(np.where(self._is_row[..., None], self.J[columns], 0.0))

    def _covariance(self, sigmas: Mapping[str, float]) -> Array:
        """Of the numbers of each pose by sources of some sizes, regular, (n, s, s)."""
        floor = np.eye(self._is_row.shape[1]) * np.where(self._is_row, FLOOR**2, 1.0)[:, None]
        return np.asarray(sum((size**2 * self._unit[name] for name, size in sigmas.items()), floor))


def _most_of_a_pose(poses: int) -> int:
    return int(np.clip(MOST_ROWS // poses, LEAST_ROWS_A_POSE, MOST_ROWS_A_POSE))
