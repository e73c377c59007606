"""Which effects are in the model: stepwise selection, with exchanges, and the geometry of a whole arm."""

from collections.abc import Sequence
from itertools import pairwise
from typing import final

import numpy as np

from robolaser.diagnosis.arm_geometry import placements_of_arm
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.localization import unmodelled_chi2
from robolaser.diagnosis.refits import Announce, Refits, penalty
from robolaser.diagnosis.score_tests import ScoreTest
from robolaser.diagnosis.thresholds import (
    CHI2_PAIR_ADVANTAGE,
    DISTINCT_SINE,
    MAX_BESIDE_GEOMETRY,
    MAX_EFFECTS,
    MAX_EXCHANGED,
    MAX_SEPARATE_EFFECTS,
    MIN_IMPROVEMENT,
    PAIRED_CANDIDATES,
    PLACEMENTS_OF_AN_ARM,
    REFITS_PER_ADDITION,
    REFITS_PER_EXCHANGE,
    REFITTED_PAIRS,
    SHARE_OF_BEST_SCORE,
    TESTED_ADDITIONS,
)
from robolaser.model.effects.link_geometry import LinkGeometry


@final
class Selection:
    """A search for the set of effects that costs least.

    Args:
        refits: Fits sets of effects.
        progress: Is called with what is being tried.
    """

    def __init__(self, refits: Refits, progress: Announce) -> None:
        self._refits, self._progress = refits, progress

    def stepwise(self, fit: Fit, most: int = MAX_EFFECTS) -> Fit:
        """Add effects while that pays; then take out or exchange each one; then begin again.

        Where an unmodelled cause explains what is left with no need of another effect, none is added.
        """
        refits = self._refits
        while True:
            options = self._better(fit, self._additions(fit, most))[:TESTED_ADDITIONS]
            added = map(refits.with_nonlinear_searched, options)
            chosen = next((option for option in added if not refits.is_unmodelled(option, fit)), None)
            if chosen is None and len(fit.effects) <= MAX_EXCHANGED:
                chosen = next(map(refits.with_nonlinear_searched, self._better(fit, self._exchanges(fit))), None)
            if chosen is None:
                return fit
            fit = chosen
            refits.linearize_again()

    def _better(self, fit: Fit, options: Sequence[Fit]) -> list[Fit]:
        """Those that cost less than a fit, the cheapest first."""
        costs = {id(option): self._refits.cost(option) for option in options}
        limit = self._refits.cost(fit) - MIN_IMPROVEMENT
        cheaper = [option for option in options if costs[id(option)] < limit]
        return sorted(cheaper, key=lambda option: costs[id(option)])

    def _additions(self, fit: Fit, most: int) -> list[Fit]:
        if len(fit.effects) >= most:
            return []
        self._progress(f"adding effects to {len(fit.effects)}")
        tests = self._refits.score_tests(fit)
        best = max((test.gain for test in tests), default=0.0)
        leaders = [t for t in tests[:REFITS_PER_ADDITION] if t.gain > max(SHARE_OF_BEST_SCORE * best, MIN_IMPROVEMENT)]
        return [self._refits.refit(fit, added) for added in ([(one,) for one in leaders] + _pairs(tests))]

    def _exchanges(self, fit: Fit) -> list[Fit]:
        self._progress(f"exchanging {len(fit.effects)} effects")
        options = []
        for one in fit.effects:
            less = self._refits.refit(fit, removed=one)
            promising = SHARE_OF_BEST_SCORE * (less.chi2 - fit.chi2)
            options.append(less)
            best = self._refits.score_tests(less)[:REFITS_PER_EXCHANGE]
            options += [self._refits.refit(less, [test]) for test in best if test.gain > promising]
        return options


def select(refits: Refits, begin: Fit | None = None, progress: Announce = lambda what: None) -> Fit:
    """The set of effects that explains the most for its cost.

    Where a few separate effects do not explain the residuals, the geometry of the whole arm is put into the model as
    one effect, and others are added to it.

    Args:
        refits: Fits sets of effects.
        begin: A set that was found before, on slightly other rows or beside other noise.
        progress: Is called with what is being tried.
    """
    selection = Selection(refits, progress)
    if begin is not None and placements_of_arm(begin.effects):
        return selection.stepwise(begin)
    few = selection.stepwise(begin or refits.start, MAX_EFFECTS if refits.start.has_optics else MAX_SEPARATE_EFFECTS)
    geometry = [test for test in refits.score_tests(refits.start) if test.candidate_effect.effect is LinkGeometry]
    enough = len(few.effects) < MAX_SEPARATE_EFFECTS and unmodelled_chi2(few) <= 0.0
    if enough or len(geometry) < PLACEMENTS_OF_AN_ARM:
        return few
    progress("fitting the geometry of the whole arm")
    arm = _reduced(refits, refits.refit(refits.start, geometry))
    arm = selection.stepwise(arm, len(arm.effects) + MAX_BESIDE_GEOMETRY)
    return min(few, arm, key=refits.cost)


def _reduced(refits: Refits, arm: Fit) -> Fit:
    """The geometry of an arm without the placements that the data say nothing of, taken out one by one."""
    while len(arm.effects) > PLACEMENTS_OF_AN_ARM:
        least = min(arm.effects, key=arm.wald)
        less = refits.refit(arm, removed=least)
        if refits.cost(less) > refits.cost(arm):
            break
        arm = less
    return arm


def _pairs(tests: Sequence[ScoreTest]) -> list[tuple[ScoreTest, ...]]:
    """Pairs that together promise far more than either does alone: effects that hide each other."""
    some = tests[:PAIRED_CANDIDATES]
    if len(some) < 2:
        return []
    alone = max(test.gain - penalty(test) for test in some)
    bases = np.hstack([test.basis for test in some])
    products, along = bases.T @ bases, bases.T @ some[0].against.at.r
    ends = np.cumsum([0] + [test.basis.shape[1] for test in some])
    spans = [np.arange(start, end) for start, end in pairwise(ends)]
    options = []
    for i, one in enumerate(some):
        for j, other in enumerate(some[:i]):
            both = np.concatenate([spans[i], spans[j]])
            squares, V = np.linalg.eigh(products[np.ix_(both, both)])
            distinct = squares > DISTINCT_SINE**2
            gain = float(((V[:, distinct].T @ along[both]) ** 2 / squares[distinct]).sum())
            net = gain - penalty(one) - penalty(other)
            if net > max(alone, 0.0) + CHI2_PAIR_ADVANTAGE:
                options.append((net, i, one, other))
    options.sort(key=lambda option: option[:2], reverse=True)
    return [(one, other) for _, _, one, other in options[:REFITTED_PAIRS]]
