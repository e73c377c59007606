"""Update of fitted models by further poses: recursive least squares.

Normal equations add up, so that a further pose needs only its own rows: residuals r and derivatives J by parameters of
covariance P raise chi-squared by rᵀ(1 + J P Jᵀ)⁻¹r and move the parameters by -P Jᵀ(1 + J P Jᵀ)⁻¹r (Plackett 1950,
Biometrika 37).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import final

import numpy as np
from scipy.special import chdtrc

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.data.joining import with_poses_of
from robolaser.diagnosis.evidence import EffectEvidence
from robolaser.diagnosis.fit import Fit
from robolaser.estimation.averaging import AveragedData
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model, jacobian, of_data, with_rows
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.sources import error_sources
from robolaser.model.stages import OF_ROWS


@final
@dataclass(frozen=True, eq=False)
class FurtherRows:
    """Rows of further poses, for all models."""

    dataset: Dataset  # all rows, these last
    shots: Ints  # number of rows of points.csv averaged in each of these, (m,)
    start: Fit  # the model without effects, fitted to the earlier rows

    @classmethod
    def of(cls, start: Fit, before: Dataset, further: Dataset) -> "FurtherRows":
        """Average the rows of the latest poses and append them to the averaged rows before."""
        averaged = AveragedData.of(further)
        return cls(with_poses_of(before, averaged.dataset), averaged.shots, start)

    def white(self, fit: Fit, x: Array) -> tuple[Array, Array]:
        """Their whitened residuals in a model with parameters x (d,), and the derivatives, (k,) and (k, d)."""
        looks_at_rows = any(one.effect.stage_in(self.dataset) in OF_ROWS for one in fit.effects)
        model = (self._whole if looks_at_rows else self._own).with_effects(fit.effects)
        last = slice(-len(self.shots), None)
        residuals, J = model.residuals(x[None])[:, last], jacobian(model, x[None])[0][:, last]
        return self._noise.whiten(residuals)[0], self._noise.whiten(J).T

    @cached_property
    def _whole(self) -> Model:
        return of_data(self.start.model, self.dataset)

    @cached_property
    def _own(self) -> Model:
        rows = len(self.dataset.points)
        return with_rows(self._whole, np.arange(rows - len(self.shots), rows))

    @cached_property
    def _noise(self) -> NoiseModel:
        return self.start.noise.of_sources(error_sources(self._own, self.start.x, self.shots))


@final
@dataclass(frozen=True, eq=False)
class Followed:
    """A model updated by further poses."""

    fit: Fit  # the fit before them
    x: Array  # the updated parameters, (d,)
    covariance: Array  # their covariance, (d, d); zero for fixed ones
    added: float = 0.0  # chi-squared added by those poses
    chance: float = 1.0  # probability of the last rows' residuals by chance

    @classmethod
    def of(cls, fit: Fit) -> "Followed":
        """A model without further poses."""
        return cls(fit, fit.x, fit.at.covariance)

    def with_rows(self, rows: FurtherRows) -> "Followed":
        """The model updated by further rows."""
        r, J = rows.white(self.fit, self.x)
        PJ = self.covariance @ J.T
        solved = np.linalg.solve(np.eye(len(r)) + J @ PJ, np.column_stack([r, PJ.T]))
        problem, added = self.fit.problem, float(r @ solved[:, 0])
        left = max(1.0, self.fit.chi2 / self.fit.freedoms)
        return Followed(
            self.fit,
            np.clip(self.x - PJ @ solved[:, 0], problem.lower, problem.upper),
            self.covariance - PJ @ solved[:, 1:],
            self.added + added,
            float(chdtrc(len(r), added / left)),
        )

    def narrowed(self, since: "Followed") -> Array:
        """Ratio of the parameters' standard deviations to those of an earlier state, (d,); 1 for fixed ones."""
        before, now = np.diag(since.covariance), np.diag(self.covariance)
        return np.sqrt(np.divide(np.maximum(now, 0.0), before, out=np.ones(len(now)), where=before > 0.0))


@final
@dataclass(frozen=True, eq=False)
class Weighed:
    """The models that a diagnosis weighed against each other, with updates by further poses."""

    start: Fit  # the model without effects
    final: Fit  # the model with all effects found
    evidence: Sequence[EffectEvidence]  # the evidence for each effect at the last full examination
    dataset: Dataset  # the averaged rows of all poses, further ones included
    followed: Mapping[Fit, Followed] = field(default_factory=dict)  # the updated models, by their fits

    def with_poses(self, further: Dataset) -> "Weighed":
        """Update all models by further poses."""
        rows = FurtherRows.of(self.start, self.dataset, further)
        rivals = (fit for one in self.evidence for fit in one.fits.values())
        followed = {fit: self.now(fit).with_rows(rows) for fit in dict.fromkeys((self.start, self.final, *rivals))}
        return replace(self, dataset=rows.dataset, followed=followed)

    def now(self, fit: Fit) -> Followed:
        """The current state of a model."""
        return self.followed.get(fit) or Followed.of(fit)

    @property
    def reweighed(self) -> tuple[EffectEvidence, ...]:
        """The evidence with the likelihoods of the further poses."""
        return tuple(map(self._reweighed, self.evidence))

    def _reweighed(self, one: EffectEvidence) -> EffectEvidence:
        added = {fit: self.followed[fit].added for fit in one.fits.values()}
        least = min(added.values())
        odds: dict[CandidateEffect | None, float] = {
            candidate: weight * float(np.exp(-0.5 * (added[one.fits[candidate]] - least)))
            for candidate, weight in one.weights.items()
        }
        models = {one.fits[candidate]: candidate for candidate in odds}.values()  # some are of several candidates
        scale = sum(one.weights[each] for each in models) / sum(odds[each] for each in models)
        weights = {candidate: scale * odd for candidate, odd in odds.items()}
        return replace(one, weights=weights, probability=weights[one.candidate_effect] * one.credibility)
