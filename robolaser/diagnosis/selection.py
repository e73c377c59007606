"""Selection of the effects in the model: stepwise, with the geometry of a whole arm as an alternative."""

from collections.abc import Iterable, Iterator

from robolaser.diagnosis.arm_geometry import placements_of_arm
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.localization import unmodelled_chi2
from robolaser.diagnosis.refits import Announce, Refits
from robolaser.diagnosis.thresholds import PLACEMENTS_OF_AN_ARM, REFITS, SEARCH_LIMIT, SHARE_OF_BEST_SCORE
from robolaser.estimation.solver import ENOUGH
from robolaser.model.effects.link_geometry import LinkGeometry


def select(
    refits: Refits, begin: Fit | None = None, separate: Fit | None = None, progress: Announce = lambda what: None
) -> Fit:
    """Select the set of effects with the lowest cost.

    If a few separate effects do not explain the residuals, the geometry of the whole arm enters the model as one
    effect, and others are added. With optics, the separate effects are kept as its rival.

    Args:
        refits: Fits sets of effects.
        begin: An earlier result on slightly different rows, or with other noise.
        separate: Its rival then.
        progress: Called with the current step.
    """
    most = 2 * SEARCH_LIMIT
    arm = begin if begin is not None and placements_of_arm(begin.effects) else None
    if arm is not None and separate is None:
        return _stepwise(refits, arm, most, progress)
    at_first = most if refits.start.has_optics else PLACEMENTS_OF_AN_ARM
    few = _stepwise(refits, separate or begin or refits.start, at_first, progress)
    arm = arm or _whole_arm(refits, few, progress)
    if arm is None:
        return few
    arm = _stepwise(refits, arm, len(arm.effects) + SEARCH_LIMIT, progress)
    if refits.cost(few) <= refits.cost(arm):
        return few
    refits.separate = few if few.has_optics else None
    return arm


def _whole_arm(refits: Refits, few: Fit, progress: Announce) -> Fit | None:
    """The geometry of the whole arm; None if a few effects suffice, or there are too few joints."""
    geometry = [test for test in refits.score_tests(refits.start) if test.candidate_effect.effect is LinkGeometry]
    enough = len(few.effects) < PLACEMENTS_OF_AN_ARM and unmodelled_chi2(few) <= 0.0
    if enough or len(geometry) < PLACEMENTS_OF_AN_ARM:
        return None
    progress("fitting the geometry of the whole arm")
    return _reduced(refits, refits.refit(refits.start, geometry))


def _stepwise(refits: Refits, fit: Fit, most: int, progress: Announce) -> Fit:
    """Add effects up to a number while that lowers the cost; then remove or replace one; and repeat."""
    while True:
        chosen = None
        if len(fit.effects) < most:
            progress(f"adding effects to {len(fit.effects)}")
            chosen = _cheapest(refits, fit, _with_one_more(refits, fit))
        if chosen is None and len(fit.effects) <= SEARCH_LIMIT:
            progress(f"exchanging {len(fit.effects)} effects")
            chosen = _cheapest(refits, fit, _with_one_exchanged(refits, fit))
        if chosen is None:
            return fit
        fit = chosen
        refits.linearize_again()


def _cheapest(refits: Refits, fit: Fit, options: Iterable[Fit]) -> Fit | None:
    """The option that costs least; None if that is no less than a fit costs."""
    best = min(options, key=refits.cost, default=fit)
    return best if refits.cost(best) < refits.cost(fit) - ENOUGH else None


def _with_one_more(refits: Refits, fit: Fit) -> Iterator[Fit]:
    tests = refits.score_tests(fit)
    promising = SHARE_OF_BEST_SCORE * max((test.gain for test in tests), default=0.0)
    yield from (refits.refit(fit, [test]) for test in tests[:REFITS] if test.gain > promising)


def _with_one_exchanged(refits: Refits, fit: Fit) -> Iterator[Fit]:
    """Fits without each of the effects, and with others instead."""
    for one in fit.effects:
        reduced = refits.refit(fit, removed=one)
        yield reduced
        promising = SHARE_OF_BEST_SCORE * (reduced.chi2 - fit.chi2)
        best = refits.score_tests(reduced)[:REFITS]
        yield from (refits.refit(reduced, [test]) for test in best if test.gain > promising)


def _reduced(refits: Refits, arm: Fit) -> Fit:
    """Remove placements without evidence from the geometry of an arm, one by one."""
    while len(arm.effects) > PLACEMENTS_OF_AN_ARM:
        least = min(arm.effects, key=arm.wald)
        reduced = refits.refit(arm, removed=least)
        if refits.cost(reduced) > refits.cost(arm):
            break
        arm = reduced
    return arm
