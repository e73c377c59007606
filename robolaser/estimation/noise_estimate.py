"""The noise of rows: as stated, as estimated from repeats, and the rest from the residuals of a fit."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.estimation.averaging import AveragedData
from robolaser.model.error_source import ErrorSource
from robolaser.model.forward_model import Model, jacobian_matrix, of_data
from robolaser.model.noise.covariance import FLOOR, NoiseModel, Origin
from robolaser.model.noise.likelihood import Known, NoiseLikelihood
from robolaser.model.noise.repeats import pixel_repeats
from robolaser.model.noise.sources import error_sources

LARGEST_SCATTER: Final = {"m": 3e-4, "rad": 5e-4}
"""Scatter of whole poses that chance may cause [m, rad]: more is a gap. Arms repeat to 0.02 mm, hobby arms to 0.5 mm
at the end of half a metre. Without a limit, poses that are free to move explain any error of a sensor."""
LARGEST_ROW_ERROR: Final = {"px": 1.0}
"""Error of a detected corner or line centre that chance may cause [px]: more is a gap. Detectors place saddle points to
0.1 px and better (Lucchese, Mitra 2002, Using saddle points for subpixel feature detection), peaks of a stripe to
0.3 px (Naidu, Fisher 1991, A comparative analysis of algorithms for determining the peak position of a stripe)."""
LEVER_M: Final = 0.3  # lever arm that converts turns to shifts. A judgement
NOISE_CONTRADICTED: Final = 1.25
"""Factor by which repeats or residuals must differ from stated noise to contradict it. A judgement."""
NOISE_CONTRADICTED_SIGMA: Final = 4.0
"""Standard deviations of chance that the difference must also exceed: once in thirty thousand data sets. A quantile."""
ROWS_ALONE: Final = 1e-2
"""Variance from whole poses over variance from rows, up to which a direction measures the rows alone. A judgement: so
few per cent of a standard deviation are negligible."""
LEAST_SHOWN: Final = 0.25
"""Share of the squared standard deviations that contradict stated noise; a smaller gain of a score test rules that out:
for one variance it is at least half of the likelihood's gain, however far the variance grows."""


@final
@dataclass(frozen=True)
class Excess:
    """Scatter of residuals relative to their expected noise."""

    ratio: float  # of standard deviations
    sigma: float  # its difference from one, in standard deviations of chance

    @classmethod
    def of(cls, squares: float, freedoms: float) -> "Excess":
        """By the cube root of chi-squared over its freedoms, which is nearly normal (Wilson, Hilferty 1931)."""
        ratio, width = max(squares, 0.0) / freedoms, 2.0 / (9.0 * freedoms)
        return cls(float(np.sqrt(ratio)), float((np.cbrt(ratio) - (1.0 - width)) / np.sqrt(width)))

    @property
    def is_above(self) -> bool:
        """Whether the noise is grossly larger than expected."""
        return self.ratio > NOISE_CONTRADICTED and self.sigma > NOISE_CONTRADICTED_SIGMA

    @property
    def is_below(self) -> bool:
        """Whether it is grossly smaller."""
        return self.ratio < 1.0 / NOISE_CONTRADICTED and self.sigma < -NOISE_CONTRADICTED_SIGMA


def noise_of(model: Model, x: Array, kept: Bools | None = None) -> NoiseModel:
    """All residuals of a fit as noise, whatever their cause: for standard errors, which must not be too small.

    Stated noise is kept; at the level of the pose there is always a free source, so that residuals larger than the
    stated noise count. Parameters on a bound are taken as not fitted: what they could not correct is left in the
    residuals.

    Returns:
        The noise of the rows that the sizes are judged by, of those that are kept (m,), repeats averaged.
    """
    data = AveragedData.of(model.dataset, None if kept is None else ~kept).subsampled(0)
    some = of_data(model, data.dataset)
    inside = (x > model.parameters.lower) & (x < model.parameters.upper)
    sources = error_sources(some, x, data.shots)
    left, J = some.residuals(x[None])[0], jacobian_matrix(some, x)[:, inside]
    return NoiseLikelihood(sources, data.dataset.points.pose, left, J).likeliest(known_sizes(sources, data.raw))[0]


@final
@dataclass(frozen=True, eq=False)
class NoiseEstimate:
    """The noise estimated from residuals, including errors of whole poses."""

    likelihood: NoiseLikelihood  # of the sizes of the sources
    known: Known  # stated ones, or estimated from repeats
    limits: Mapping[str, float]  # upper limits of estimated sizes, by name, see `noise_limits`
    numbers: int  # how many whitened numbers there are

    @classmethod
    def of(cls, data: AveragedData, model: Model, x: Array, J: Array | None = None) -> "NoiseEstimate":
        """From the residuals of a model of averaged rows at x (d,).

        Columns J (K, n) may explain the residuals; by default the derivatives by the parameters.
        """
        sources = error_sources(model, x, data.shots)
        residuals, of_pose = model.residuals(x[None])[0], data.dataset.points.pose
        likelihood = NoiseLikelihood(sources, of_pose, residuals, jacobian_matrix(model, x) if J is None else J)
        limits = noise_limits(sources, data.dataset, alone=bool(np.bincount(of_pose).max() == 1))
        return cls(likelihood, known_sizes(sources, data.raw), limits, int(model.blocks.row_numbers.sum()))

    def loosened(self, names: Collection[str], further: tuple[ErrorSource, ...] = ()) -> "NoiseEstimate":
        """The same with named and further sources estimated from the residuals, whether stated or not."""
        likelihood = replace(self.likelihood, sources=(*self.likelihood.sources, *further))
        limits = {name: limit for name, limit in self.limits.items() if name not in names}
        known = {name: size for name, size in self.known.items() if name not in names}
        return replace(self, likelihood=likelihood, known=known, limits=limits)

    @cached_property
    def limited(self) -> NoiseModel:
        """The likeliest noise within the limits.

        Where the rows of a pose contradict the stated noise, the larger one is used: else a source of another shape
        would absorb the rest, and rows where that is too small would look like gross errors.
        """
        likelihood, known = self.likelihood, self.known
        likeliest, cost = likelihood.likeliest(known)
        noise = self._within_reach(likeliest, known)
        rows = {source.name for source in likelihood.sources if source.level != "pose"}
        least = {
            name: size for name, (size, origin) in known.items() if name in rows and origin == "stated" and size > 0.0
        }
        white = left_by(noise, likelihood.residuals, likelihood.J)
        is_above = row_excess(noise, white, self.numbers - likelihood.J.shape[1]).is_above
        if not is_above and (
            not least
            or len(known) == len(likelihood.sources)
            or likelihood.gain_of_growth(likeliest, least) < LEAST_SHOWN * NOISE_CONTRADICTED_SIGMA**2
        ):
            return noise
        still = {name: size for name, size in known.items() if name not in least}
        larger, less = likelihood.likeliest(still, least)
        is_grown = any(larger.sigmas[name] > NOISE_CONTRADICTED * size for name, size in least.items())
        if is_above or (is_grown and 2.0 * (cost - less) > NOISE_CONTRADICTED_SIGMA**2):
            return self._within_reach(larger, still, least)
        return noise

    def for_weights(self) -> NoiseModel:
        """The noise for weights: of rows, estimated from the residuals."""
        return replace(self, limits={}).of_rows()

    def of_rows(self) -> NoiseModel:
        """The likeliest noise of rows within the limits, without unstated errors of whole poses."""
        sources = self.likelihood.sources
        rows = [source.name for source in sources if source.level != "pose"]
        if all(source.level == "pose" or source.name in self.known for source in sources):
            sizes = {source.name: self.known.get(source.name, (0.0, "estimated")) for source in sources}
            return NoiseModel(
                sources,
                {name: size for name, (size, _) in sizes.items()},
                {name: by for name, (_, by) in sizes.items()},
            )
        limits = {name: limit for name, limit in self.limits.items() if name in rows}
        found, _ = self.likelihood.likeliest(self.known)
        return _without_scatter(replace(self, limits=limits)._within_reach(found, self.known))

    def _within_reach(self, noise: NoiseModel, known: Known, least: Mapping[str, float] | None = None) -> NoiseModel:
        """Estimated noise in which no size is beyond its limit: more is a gap.

        The other sources are estimated with these at their limits.
        """
        while True:
            beyond = [
                name
                for name in noise.estimated
                if noise.sigmas[name] > self.limits.get(name, np.inf) and name not in known
            ]
            if not beyond:
                return noise
            known = {**known, **{name: (self.limits[name], "estimated") for name in beyond}}
            noise = self.likelihood.likeliest(known, least)[0]


def weights_of_sizes(data: AveragedData, model: Model, x: Array, sizes: Mapping[str, float]) -> NoiseModel:
    """The noise for weights of averaged rows at x (d,), of sources whose sizes are known by name."""
    sources = error_sources(model, x, data.shots)
    origin: dict[str, Origin] = {one.name: "estimated" if one.stated is None else "stated" for one in sources}
    return _without_scatter(NoiseModel(sources, {one.name: sizes.get(one.name, 0.0) for one in sources}, origin))


def _without_scatter(noise: NoiseModel) -> NoiseModel:
    """Without unstated errors of whole poses: those contain what the model lacks.

    Rows of a pose that fit each other exactly were made from one measurement: then only errors of whole poses are
    known. Where each pose has one row, its errors are the row's.
    """
    if all(len(np.unique(source.group)) == len(source.group) for source in noise.sources):
        return noise
    rows = [source.name for source in noise.sources if source.level != "pose"]
    exact = all(name in noise.estimated and noise.sigmas[name] < FLOOR for name in rows)
    return noise if exact else noise.for_weights()


def row_excess(noise: NoiseModel, white: Array, freedoms: int) -> Excess:
    """Scatter of rows within their poses relative to their noise.

    By the whitened residuals (K,) of a fit, with so many degrees of freedom.
    """
    of_poses = noise.scatter > ROWS_ALONE
    squares = float(white @ white - noise.scatter_squares(white)[of_poses].sum())
    return Excess.of(squares, float(max(1, freedoms - int(np.count_nonzero(of_poses)))))


def left_by(noise: NoiseModel, residuals: Array, J: Array) -> Array:
    """Whitened residuals without what columns J (K, n) explain, (K,)."""
    length = np.linalg.norm(J, axis=0)
    unit = J / np.where(length > 0.0, length, 1.0)
    Q = np.linalg.qr(noise.whiten(unit.T.reshape(-1, *residuals.shape)).T)[0]
    white = noise.whiten(residuals[None])[0]
    return np.asarray(white - Q @ (Q.T @ white))


def known_sizes(sources: tuple[ErrorSource, ...], raw: Dataset) -> Known:
    """Stated sizes, and the pixel noise from repeats, if it is not stated or grossly larger than stated."""
    known: dict[str, tuple[float, Origin]] = {
        source.name: (source.stated, "stated") for source in sources if source.stated is not None
    }
    for sensor in raw.sensors:
        name = f"{sensor.prefix}pixel"
        repeats = pixel_repeats(sensor.data) if any(source.name == name for source in sources) else None
        if repeats is None:
            continue
        size = known[name][0] if name in known else 0.0
        if not size or Excess.of(repeats.freedoms * (repeats.sigma_px / size) ** 2, repeats.freedoms).is_above:
            known[name] = repeats.sigma_px, "repeats"
    return known


def noise_limits(sources: Collection[ErrorSource], dataset: Dataset, *, alone: bool) -> Mapping[str, float]:
    """The largest standard deviation that counts as noise, by name of source and in its unit, where there is a limit.

    A stated repeatability limits the root-mean-square shift of the flange by a single source. Coarse steps of the
    readings are added.

    Args:
        sources: The noise sources of the rows.
        dataset: With the arm's poses and the stated repeatability.
        alone: Whether each pose has one row: then the row's errors are the pose's.
    """
    stated = dataset.noise.repeatability_m
    rounding = dataset.noise.rounding_rad
    usual = {}
    for source in sources:
        of_pose = alone or source.level == "pose"
        largest = LARGEST_ROW_ERROR | (LARGEST_SCATTER if of_pose else {})
        if source.unit in largest:
            usual[source.name] = largest[source.unit]
    if "joint" in usual:
        usual["joint"] = float(np.hypot(usual["joint"], rounding))
    if stated is None:
        return usual
    axis = stated / np.sqrt(3.0)
    return usual | {
        source.name: float(np.hypot(stated / _reach(dataset), rounding))
        if source.name == "joint"
        else axis
        if source.unit == "m"
        else axis / LEVER_M
        for source in sources
        if source.level == "pose"
    }


def _reach(dataset: Dataset) -> float:
    """Shift of the flange by a unit error of each joint, root mean square over the poses with points [m/rad]."""
    robot, q = dataset.arm
    J = robot.jacobian(q[None, np.unique(dataset.points.pose)])[0, :, :3]
    return float(np.sqrt(np.square(J).sum(axis=(1, 2)).mean()))
