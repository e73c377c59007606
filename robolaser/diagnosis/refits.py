"""Fits of sets of effects, computed once, and their costs."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.arm_geometry import placements_of_arm
from robolaser.diagnosis.effect_columns import Columns, prior_scales
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.local_unknown import (
    chance_chi2,
    has_form,
    local_unknown_chi2,
    posture_unknown_chi2,
    probability_of_local_unknown,
)
from robolaser.diagnosis.localization import unmodelled_chi2
from robolaser.diagnosis.penalties import posterior_weights
from robolaser.diagnosis.score_tests import ScoreTest, retest, score_tests
from robolaser.diagnosis.sparse_shapes import sparse_shape_chi2
from robolaser.diagnosis.thresholds import CHI2_OF_UNMODELLED_CAUSE, CHI2_PER_EFFECT, LEAST_PROBABILITY
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import ENOUGH
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.joints import moving_joints

Announce = Callable[[str], None]
"""Called with the current step in words."""
Chi2By = Callable[..., float]
"""Evaluates the chi-squared that a function of a fit and a site returns."""


@final
@dataclass
class Refits:
    """Fits of all sets of effects that were tried."""

    start: Fit  # the model without effects, fitted
    effects: Sequence[CandidateEffect]  # candidate effects
    separate: Fit | None = None  # effects that cost more than the selected geometry of the whole arm, if any
    _fits: dict[frozenset[CandidateEffect], Fit] = field(default_factory=dict)
    _tests: dict[frozenset[CandidateEffect], list[ScoreTest]] = field(default_factory=dict)
    _begun: set[tuple[frozenset[CandidateEffect], tuple[object, ...]]] = field(default_factory=set)
    _unknown: dict[tuple[object, ...], tuple[float, float]] = field(default_factory=dict)
    _columns: Columns = field(default_factory=Columns)
    _latest: dict[CandidateEffect, ScoreTest] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._fits[frozenset(self.start.effects)] = self.start

    def refit(self, near: Fit, added: Sequence[ScoreTest] = (), removed: CandidateEffect | None = None) -> Fit:
        """Fit a set of effects from another fit, with some added and one removed, starting at the linear prediction."""
        kept = tuple(one for one in near.effects if one != removed)
        effects = (*kept, *(test.candidate_effect for test in added))
        key = frozenset(effects)
        begun = tuple(sorted(test.key for test in added))
        if key in self._fits and (not added or (key, begun) in self._begun):
            return self._fits[key]
        self._begun.add((key, begun))
        self._latest |= {test.candidate_effect: test for test in added}
        problem = self._problem(effects)
        values = near.values | (_predicted(near, added) if added else {})
        x = np.array([values[name] for name in problem.parameters.names])
        rival = min(fit.chi2 for fit in self._fits.values())
        fit = Fit.of(problem, x, self._slopes_near(near, added, values, problem), rival)
        if key not in self._fits or fit.chi2 < self._fits[key].chi2 - ENOUGH:
            self._fits[key] = fit
        return self._fits[key]

    def _slopes_near(
        self, near: Fit, added: Sequence[ScoreTest], values: Mapping[str, float], problem: Problem
    ) -> Array | None:
        """Derivatives (d, K) by a problem's parameters from a fit with other effects; None if some are unknown."""
        if len(problem.batches) > 1:
            return None
        slopes = dict(zip(near.problem.parameters.names, near.at.slopes.T, strict=True))
        for one in [test.candidate_effect for test in added]:
            columns = self._columns.by_parameters(near, one, np.array([values[name] for name in one.parameters.names]))
            if columns is None:
                return None
            slopes |= dict(zip(one.parameters.names, (columns * one.parameters.width).T, strict=True))
        return np.array([slopes[name] for name in problem.parameters.names])

    def without(self, fit: Fit, effects: Iterable[CandidateEffect]) -> Fit:
        """Refit without some effects, removing one at a time."""
        for one in effects:
            fit = self.refit(fit, removed=one)
        return fit

    def of(self, near: Fit, added: Sequence[ScoreTest] = ()) -> Fit:
        """The best fit so far of a set of effects, or else a new one."""
        key = frozenset((*near.effects, *(test.candidate_effect for test in added)))
        return self._fits[key] if key in self._fits else self.refit(near, added)

    def _problem(self, effects: tuple[CandidateEffect, ...]) -> Problem:
        return problem_of(self.start.model.with_effects(effects), self.start.noise, self.start.sensor)

    def warm_start(self, earlier: Fit, refits: "Refits") -> Fit:
        """Fit the effects that were found on slightly different rows, starting at their optimum."""
        self._latest |= {test.candidate_effect: retest(test, self.start) for test in refits.tests_of(earlier)}
        fit = Fit.of(self._problem(earlier.effects), earlier.x)
        self._fits[frozenset(earlier.effects)] = fit
        return fit

    def linearize_again(self) -> None:
        """Discard derivatives of earlier models."""
        self._columns = Columns()

    def score_tests(self, fit: Fit) -> list[ScoreTest]:
        """Score tests of all candidates outside a fit, best first."""
        key = frozenset(fit.effects)
        if key not in self._tests:
            found = score_tests(fit, self.effects, self._columns)
            self._tests[key] = sorted(found, key=lambda test: test.penalty - test.gain)
        return self._tests[key]

    def tests_of(self, fit: Fit) -> list[ScoreTest]:
        """The score tests of a fit's effects when they were added."""
        return [self._latest[one] for one in fit.effects]

    def cost(self, fit: Fit) -> float:
        """Deviance plus complexity penalties of the effects; infinite where a point is behind the camera."""
        return fit.deviance + self._penalties(fit) if np.isfinite(fit.chi2) else np.inf

    def cost_by_chi2(self, fit: Fit) -> float:
        """Chi-squared, with the assumed scatter of whole poses, plus complexity penalties."""
        return fit.chi2 + self._penalties(fit) if np.isfinite(fit.chi2) else np.inf

    def _penalties(self, fit: Fit) -> float:
        """Penalties of a fit's effects. A whole arm's geometry is one effect, and costs its marginal likelihood."""
        arm = placements_of_arm(fit.effects)
        price = CHI2_PER_EFFECT + fit.marginal_cost(arm) if arm else 0.0
        return price + sum(test.penalty for test in self.tests_of(fit) if test.candidate_effect not in arm)

    def unmodelled(self, fit: Fit, without: Fit) -> float:
        """Probability that an unmodelled cause explains the same as some effects and makes them unnecessary.

        Smooth functions of any form at any site represent that cause, beside the effects and instead of them.
        """
        costs = self._beside_unmodelled(fit), self._beside_unmodelled(without) + CHI2_OF_UNMODELLED_CAUSE
        return float(posterior_weights(np.array(costs))[1])

    def locally_unmodelled(self, fit: Fit, candidate_effect: CandidateEffect) -> float:
        """Probability of an unknown cause at a joint instead of an effect, or of all effects there, or beside them.

        It is a function of unknown form, a sparse shape, or chance from pose to pose. Probabilities too low to be
        reported count as zero.
        """
        joint, without = candidate_effect.where, self.refit(fit, removed=candidate_effect)
        beside = [one for one in without.effects if one.where == joint and has_form(fit, one)]
        sets = dict.fromkeys((without, self.without(without, beside)))
        unknown = max(self._probability_instead(fit, one, joint) for one in sets)
        return unknown if unknown >= LEAST_PROBABILITY else 0.0

    def _probability_instead(self, fit: Fit, without: Fit, joint: str) -> float:
        """Probability of the likeliest rival of the effects that one fit lacks.

        Each has the lower of its probabilities with the assumed scatter of whole poses and with the likeliest one.
        """
        rivals = self._of_any_form, self._of_sparse_shape, self._by_chance
        assumed = ((rival, rival(fit, without, joint, self._once)) for rival in rivals)
        reported = [(rival, unknown) for rival, unknown in assumed if unknown >= LEAST_PROBABILITY]
        if not reported or (rescattered := fit.with_likeliest_scatter) is fit:
            return max((unknown for _, unknown in reported), default=0.0)
        refitted = Fit.of(without.problem.with_noise(rescattered.noise), without.x)
        once = cache(lambda chi2_of, *at: chi2_of(*at))
        return max(min(unknown, rival(rescattered, refitted, joint, once)) for rival, unknown in reported)

    def _of_any_form(self, fit: Fit, without: Fit, joint: str, chi2_by: Chi2By) -> float:
        """Probability of a function of unknown form instead of the effects, or, at a joint, also beside them."""
        left = chi2_by(local_unknown_chi2, fit, joint) if joint in moving_joints(fit.model.dataset.robot) else 0.0
        instead = chi2_by(local_unknown_chi2, without, joint)
        return probability_of_local_unknown(self.cost_by_chi2(fit), left, self.cost_by_chi2(without), instead)

    def _by_chance(self, fit: Fit, without: Fit, joint: str, chi2_by: Chi2By) -> float:
        """Probability of pose-to-pose scatter of a joint instead of the effects."""
        by_chance = self.cost_by_chi2(without) - chi2_by(chance_chi2, without, joint) + CHI2_PER_EFFECT
        return float(posterior_weights(np.array([self.cost_by_chi2(fit), by_chance]))[1])

    def _of_sparse_shape(self, fit: Fit, without: Fit, site: str, chi2_by: Chi2By) -> float:
        """Probability of a sparse shape at a site instead of the effects.

        Alternatively the effects have an inexact form, with a function beside them that is outside the library, too; or
        the shape is present beside them.
        """
        price = CHI2_PER_EFFECT + CHI2_OF_UNMODELLED_CAUSE
        form, beside = chi2_by(local_unknown_chi2, fit, site), chi2_by(sparse_shape_chi2, fit, site)
        final = self.cost_by_chi2(fit) - max(0.0, form - CHI2_OF_UNMODELLED_CAUSE, beside - price)
        instead = self.cost_by_chi2(without) - chi2_by(sparse_shape_chi2, without, site) + price
        return float(posterior_weights(np.array([final, instead]))[1])

    def cost_beside_posture_unknown(self, fit: Fit) -> float:
        """Cost of a fit beside a smooth function that turns several joints, with the penalty of an effect."""
        return self.cost_by_chi2(fit) - (self._once(posture_unknown_chi2, fit) - CHI2_PER_EFFECT)

    def _beside_unmodelled(self, fit: Fit) -> float:
        return self.cost_by_chi2(fit) - self._once(unmodelled_chi2, fit)

    def _once(self, chi2_of: Callable[..., float], fit: Fit, *site: str) -> float:
        """Chi-squared of an unknown cause beside a set of effects, recomputed only for a changed fit of the set."""
        key = chi2_of, frozenset(fit.effects), *site
        if key not in self._unknown or self._unknown[key][0] != fit.chi2:
            self._unknown[key] = fit.chi2, chi2_of(fit, *site)
        return self._unknown[key][1]


@final
@dataclass(frozen=True)
class PostureRivals:
    """A single function of unknown form that turns several joints: the rival of several effects together.

    Cable drag at the wrist looks like a joint's compliance, a rotated link and a sagging bracket. Each of these effects
    is needed beside the others, but one unknown function explains as much as all of them.
    """

    held: tuple[frozenset[CandidateEffect], ...]  # effects of the final model in each model with such a function
    weights: tuple[float, ...]  # their probabilities; the remainder to 1 is that of the final model without one

    @classmethod
    def of(cls, refits: Refits, final: Fit) -> "PostureRivals":
        """Weigh models with all effects, all but one, and ever fewer, removing the least needed first."""
        single = {one: refits.refit(final, removed=one) for one in final.effects}
        models = {frozenset(fit.effects): fit for fit in (final, *single.values())}
        costs = {held: refits.cost_beside_posture_unknown(fit) for held, fit in models.items()}
        reduced, alone = final, refits.cost_by_chi2(final)
        for one in sorted(single, key=lambda one: costs[frozenset(single[one].effects)]):
            reduced = refits.refit(reduced, removed=one)
            costs[frozenset(reduced.effects)] = refits.cost_beside_posture_unknown(reduced)
        weights = posterior_weights(np.array([alone, *costs.values()]))
        return cls(tuple(costs), tuple(weights[1:].tolist()))

    def unmodelled(self, effects: Iterable[CandidateEffect]) -> float:
        """Probability of such a function without any of some effects."""
        excluded = frozenset(effects)
        return float(sum(weight for held, weight in zip(self.held, self.weights, strict=True) if not held & excluded))


def _predicted(near: Fit, added: Sequence[ScoreTest]) -> dict[str, float]:
    """All parameters with added effects by the linear model, by name."""
    white = np.hstack([test.white for test in added])
    amplitudes = near.best_amplitudes(white)
    values = dict(zip(near.problem.parameters.names, near.moved(white, amplitudes).tolist(), strict=True))
    at = 0
    for test in added:
        scale = prior_scales(test.candidate_effect)
        numbers = (*(amplitudes[at : at + len(scale)] * scale), *test.nonlinear)
        values |= dict(zip(test.candidate_effect.parameters.names, numbers, strict=True))
        at += len(scale)
    return values
