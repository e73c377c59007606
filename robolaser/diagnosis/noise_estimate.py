"""The noise of averaged rows: what is stated, what repeats say, and what the residuals say of the rest."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.averaging import AveragedData
from robolaser.diagnosis.scatter_limits import scatter_limits
from robolaser.diagnosis.thresholds import NOISE_CONTRADICTED, NOISE_CONTRADICTED_SIGMA, ROWS_ALONE
from robolaser.model.derivatives import jacobian_matrix
from robolaser.model.error_source import ErrorSource
from robolaser.model.forward_model import Model
from robolaser.model.noise.covariance import (
    FLOOR,
    Known,
    NoiseLikelihood,
    NoiseModel,
    Origin,
    known_sizes,
)
from robolaser.model.noise.repeats import pixel_repeats
from robolaser.model.noise.sources import error_sources

LEAST_SHOWN = 0.25
"""Of the squared standard deviations that contradict stated noise, below which a score test's gain rules that out: for
one variance it is at least half of what the likelihood gains, however far the variance grows."""


@final
@dataclass(frozen=True)
class Excess:
    """How much residuals scatter beyond the noise that they should have.

    Attributes:
        ratio: Of standard deviations.
        sigma: How far that is from one, in standard deviations of chance.
    """

    ratio: float
    sigma: float

    @classmethod
    def of(cls, squares: float, freedoms: float) -> "Excess":
        """By the cube root of chi-squared over its freedoms, which is nearly normal (Wilson, Hilferty 1931)."""
        ratio, width = max(squares, 0.0) / freedoms, 2.0 / (9.0 * freedoms)
        return cls(float(np.sqrt(ratio)), float((np.cbrt(ratio) - (1.0 - width)) / np.sqrt(width)))

    @property
    def is_above(self) -> bool:
        """Whether the noise is grossly larger than it should be."""
        return self.ratio > NOISE_CONTRADICTED and self.sigma > NOISE_CONTRADICTED_SIGMA

    @property
    def is_below(self) -> bool:
        """Whether it is grossly smaller."""
        return self.ratio < 1.0 / NOISE_CONTRADICTED and self.sigma < -NOISE_CONTRADICTED_SIGMA


def row_noise(data: AveragedData, model: Model, x: Array, shots: Dataset) -> NoiseModel:
    """The noise of the averaged rows without errors of whole poses that nobody stated, at x (d,).

    With it a first fit is made: how whole poses scatter is estimated from what that leaves.

    Args:
        data: The rows.
        model: Of them.
        x: Its parameters.
        shots: The data set with its repeats.
    """
    sources = _sources(data, model, x)
    known = _known(sources, shots)
    if any(source.level != "pose" and source.name not in known for source in sources):
        left, J = model.residuals(x[None])[0], jacobian_matrix(model, x)
        return _without_pose_errors(NoiseLikelihood(sources, data.dataset.points.pose, left, J).likeliest(known)[0])
    return NoiseModel(
        sources, {source.name: known[source.name][0] if source.name in known else 0.0 for source in sources}
    )


def whole_noise(data: AveragedData, model: Model, x: Array, J: Array, shots: Dataset) -> NoiseModel:
    """The same with errors of whole poses, from what columns J (K, n) leave of the residuals.

    Where the rows of a pose contradict what is stated, the larger noise is used: else another source, of another shape,
    takes what was left out, and rows where that is too small look like gross errors.
    """
    return PoseNoise.of(data, model, x, J, shots).limited()


@final
@dataclass(frozen=True, eq=False)
class PoseNoise:
    """What residuals say of noise, errors of whole poses among it.

    Attributes:
        likelihood: Of the sizes of the sources.
        known: Those that are stated, or that repeats give.
        limits: What errors of whole poses are not above, by name, see `scatter_limits`.
        residuals: Plain ones, (m, k).
        J: What could explain them, (K, n).
        numbers: How many whitened numbers there are.
    """

    likelihood: NoiseLikelihood
    known: Known
    limits: Mapping[str, float]
    residuals: Array
    J: Array
    numbers: int

    @classmethod
    def of(cls, data: AveragedData, model: Model, x: Array, J: Array, shots: Dataset) -> "PoseNoise":
        """From what columns J (K, n) leave of the residuals of a model at x (d,)."""
        sources, residuals = _sources(data, model, x), model.residuals(x[None])[0]
        likelihood = NoiseLikelihood(sources, data.dataset.points.pose, residuals, J)
        limits = scatter_limits(sources, data.dataset, alone=bool(np.bincount(likelihood.of_pose).max() == 1))
        return cls(likelihood, _known(sources, shots), limits, residuals, J, int(model.blocks.row_numbers.sum()))

    def loosened(self, names: Collection[str], further: tuple[ErrorSource, ...] = ()) -> "PoseNoise":
        """The same with some sources as large as the residuals say, whatever is stated of them.

        Args:
            names: Of these sources.
            further: Sources that are added.
        """
        likelihood = replace(self.likelihood, sources=(*self.likelihood.sources, *further))
        limits = {name: limit for name, limit in self.limits.items() if name not in names}
        known = {name: size for name, size in self.known.items() if name not in names}
        return replace(self, likelihood=likelihood, known=known, limits=limits)

    def limited(self) -> NoiseModel:
        """The likeliest noise within the limits."""
        likelihood, known = self.likelihood, self.known
        likeliest, cost = likelihood.likeliest(known)
        noise = self._within_reach(likeliest, known)
        rows = {source.name for source in likelihood.sources if source.level != "pose"}
        least = {
            name: size for name, (size, origin) in known.items() if name in rows and origin == "stated" and size > 0.0
        }
        white = left_by(noise, self.residuals, self.J)
        is_above = row_excess(noise, white, self.numbers - self.J.shape[1]).is_above
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

    def _within_reach(self, noise: NoiseModel, known: Known, least: Mapping[str, float] | None = None) -> NoiseModel:
        """Estimated noise without scatter of whole poses beyond its limits: more is a gap.

        The other sources are estimated beside the scatter that is left.
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


def row_excess(noise: NoiseModel, white: Array, freedoms: int) -> Excess:
    """How much rows scatter within their poses, beyond their noise.

    Args:
        noise: Of them.
        white: Whitened residuals (K,) that a fit left.
        freedoms: Their numbers less those that were fitted.
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


def _known(sources: tuple[ErrorSource, ...], shots: Dataset) -> dict[str, tuple[float, Origin]]:
    """Stated sizes and that of the pixels from repeats, if nobody states it or it is grossly larger than is stated."""
    known = known_sizes(sources, shots)
    for prefix, part in shots.named_parts:
        size, origin = known.get(f"{prefix}pixel", (0.0, "estimated"))
        repeats = pixel_repeats(part) if origin == "stated" else None
        if repeats and Excess.of(repeats.freedoms * (repeats.sigma_px / size) ** 2, repeats.freedoms).is_above:
            known[f"{prefix}pixel"] = repeats.sigma_px, "repeats"
    return known


def _sources(data: AveragedData, model: Model, x: Array) -> tuple[ErrorSource, ...]:
    """The noise sources of the rows.

    Where each pose has one row only, a motion of the pose would be the row's error under another name; errors of
    joint readings are not, since what they do depends on the posture.
    """
    alone = np.bincount(data.dataset.points.pose).max() == 1
    share = 1.0 / np.sqrt(data.shots)[:, None, None]
    return tuple(
        replace(source, effect=source.effect * share) if source.level == "shot" else source
        for source in error_sources(model, x)
        if not alone or source.level != "pose" or source.name == "joint" or source.stated is not None
    )


def _without_pose_errors(noise: NoiseModel) -> NoiseModel:
    """Noise without estimated errors of whole poses, which hold what the model lacks.

    Where rows of a pose fit each other exactly, they were made from one measurement: then they say nothing about its
    errors, and those of whole poses are all that is known. Where each pose has one row, its errors are the row's.
    """
    if all(len(np.unique(source.group)) == len(source.group) for source in noise.sources):
        return noise
    rows = [source.name for source in noise.sources if source.level != "pose"]
    exact = all(name in noise.estimated and noise.sigmas[name] < FLOOR for name in rows)
    return noise if exact else noise.for_weights()
