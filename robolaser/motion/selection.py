"""The effects of a model of rows: added and removed by their evidence, and compared with rivals."""

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np
from scipy.special import expit

from robolaser.arrays import Array
from robolaser.estimation.certainty import EVEN
from robolaser.motion.effect import UNKNOWN, At, Number
from robolaser.motion.evidence import Fitted

WORTH_ADDING = 4.0  # in twice the logarithm of the evidence: seven to one
TRIED = 3  # best candidates of the previous round, which are fitted before all others
INDISTINGUISHABLE = 6.0  # the same: a rival that is up to twenty to one worse
ALIKE = 1e-3  # share by which squares of the same effect at a neighbour may be larger if both are one motion
Sets = Sequence[tuple[At, ...]]
Estimate = tuple[float, float, str]  # an estimated number: value, standard deviation, unit
Fitting = Callable[[Sequence[tuple[int, tuple[At, ...]]]], Sequence[Fitted]]
"""A model of the rows of each search, with each set of effects."""
EffectSearch = Generator[Sets, Sequence[Fitted], "Selection"]


@final
@dataclass(frozen=True, eq=False)
class SelectedEffect:
    """An effect of a model, compared with no effect and with rivals."""

    at: At
    probability: float
    none: float  # probability that neither it nor a rival is present
    without: Fitted
    rivals: tuple[At, ...]  # that explain nearly as much instead
    numbers: Mapping[str, Estimate] = field(default_factory=dict)  # by name, once fitted
    gained: Array = field(default_factory=lambda: np.empty(0))  # explained mean squares of each joint, (j,)
    may_be_pulled: bool = False  # whether an unknown torque may be its cause, and that of others

    @property
    def is_on_bound(self) -> bool:
        """Whether one of several numbers is at its lower bound: an undamped lag is another cause."""
        return len(self._values) > 1 and any(-np.inf < value <= one.lower for one, value in self._values)

    @property
    def is_large(self) -> bool:
        """Whether one of its numbers is so large that no other effect imitates it."""
        return not self._values or any(abs(value) >= one.least for one, value in self._values)

    @property
    def _values(self) -> list[tuple[Number, float]]:
        """Its fitted numbers."""
        return [(one, self.numbers[one.name][0]) for one in self.at.effect.numbers if one.name in self.numbers]

    def beside(self, rivals: Sequence[At], most: float) -> "SelectedEffect":
        """The same with more rivals and no more than a given probability."""
        more = tuple(one for one in rivals if one.effect.name not in {rival.effect.name for rival in self.rivals})
        return replace(self, probability=min(self.probability, most), rivals=(*self.rivals, *more))

    def doubted(self, most: float) -> "SelectedEffect":
        """The same with no more than a given probability."""
        return replace(self, probability=min(self.probability, most), none=max(self.none, 1.0 - most))

    def less(self, rival: str) -> "SelectedEffect":
        """The same without the rival of that name, which is known to be absent."""
        left = tuple(one for one in self.rivals if one.effect.name != rival)
        if len(left) == len(self.rivals):
            return self
        share = self.probability / (self.probability + self.none) if not left else self.probability
        return replace(self, probability=share, rivals=left)


@final
@dataclass(frozen=True)
class Selection:
    """A model and its effects, the most important first."""

    ideal: Fitted
    model: Fitted
    findings: tuple[SelectedEffect, ...]


def search(
    candidates: Sequence[At], least_share: float, usual: Array | float = np.inf, start: tuple[At, ...] = ()
) -> EffectSearch:
    """Find the effects; each step yields sets of effects and receives models with them.

    Several searches run side by side, so that their models can be fitted together: see `side_by_side`.

    Args:
        candidates: All effects that may be present, and functions of unknown form, which are rivals only.
        least_share: Share of an ideal arm's squares at one joint that an effect must explain: less may be the form of
            another one, unless it is half of the remaining squares.
        usual: Squares that models of arms usually leave, (j,): to explain half of less is no evidence.
        start: Effects at the start of the search.
    """

    def is_worth(more: Fitted, less: Fitted) -> bool:
        gained = less.squares - more.squares
        closes = (less.squares > usual) & (gained >= EVEN * less.squares)
        explained = closes | (gained >= least_share * ideal.squares)
        return bool(explained[ideal.squares > 0.0].any()) and more.score < less.score - WORTH_ADDING

    functions = [one for one in candidates if one.effect.cause == UNKNOWN]
    candidates = [one for one in candidates if one.effect.cause != UNKNOWN]
    ideal, model = yield [(), start]
    passed = {model.names}
    gain = dict.fromkeys(candidates, float("inf"))
    while True:
        left = [one for one in candidates if one not in model.effects]
        stale = sorted(left, key=gain.__getitem__, reverse=True)
        found: Fitted | None = None
        for tried in (stale[:TRIED], stale[TRIED:]) if any(g < float("inf") for g in gain.values()) else (stale,):
            if not tried:
                continue
            fits = yield [_with(model.effects, one) for one in tried]
            gain.update((one, model.score - fit.score) for one, fit in zip(tried, fits, strict=True))
            worth = [fit for fit in fits if is_worth(fit, model)]
            if worth:
                found = min(worth, key=_by_evidence)
                break
        following = found or (yield from _reduced(model, is_worth))
        if following.names in passed:
            break
        model = following
        passed.add(model.names)
    while True:
        without = yield [tuple(o for o in model.effects if o != one) for one in model.effects]
        swaps = [
            [_with(less.effects, rival) for rival in _rivals(one, model, candidates)]
            for one, less in zip(model.effects, without, strict=True)
        ]
        fits = yield [effects for group in swaps for effects in group]
        best = min(fits, key=_by_evidence, default=model)
        if best.score >= model.score:
            break
        model = best
    instead = iter(fits)
    findings = [
        _finding(one, model, less, [(rival[-1], next(instead)) for rival in group])
        for one, less, group in zip(model.effects, without, swaps, strict=True)
    ]
    findings = yield from _beside_functions(findings, model, functions)
    findings.sort(key=lambda one: one.without.score, reverse=True)
    return Selection(ideal, model, tuple(findings))


def chosen(effects: Sequence[At]) -> EffectSearch:
    """The effects that the user requests, instead of a search."""
    ideal, model = yield [(), tuple(effects)]
    without = yield [tuple(other for other in effects if other != one) for one in effects]
    findings = [SelectedEffect(one, 1.0, 0.0, less, ()) for one, less in zip(effects, without, strict=True)]
    return Selection(ideal, model, tuple(findings))


def _by_evidence(fit: Fitted) -> tuple[float, float]:
    """Sort key of models, the best first: by residuals where these are within the error of the model's form."""
    return fit.score, float(fit.squares.sum())


def _with(effects: tuple[At, ...], one: At) -> tuple[At, ...]:
    """Effects and one more, which replaces its other form."""
    return (*(other for other in effects if other.pair != one.pair), one)


def _finding(one: At, model: Fitted, without: Fitted, instead: Sequence[tuple[At, Fitted]]) -> SelectedEffect:
    """Compare an effect with its rivals.

    Within the error of the models' form the one of fewest numbers is selected; a rival is then as likely if it would be
    better without that error: it may leave less because it is true.
    """
    instead = [(rival, fit) for rival, fit in instead if rival.pair != one.pair]

    def score(rival: At, fit: Fitted) -> float:
        alike = rival.effect.name == one.effect.name and bool((fit.squares <= (1.0 + ALIKE) * model.squares).all())
        return min(fit.score, model.score) if alike or fit.exact < model.exact else fit.score

    instead = [(rival, replace(fit, score=score(rival, fit))) for rival, fit in instead]
    scores = np.array([model.score, without.score, *(fit.score for _, fit in instead)])
    with np.errstate(invalid="ignore"):  # a search that starts from impossible effects is never chosen
        evidence = np.exp(-0.5 * (scores - scores.min()))
    share = evidence / evidence.sum()
    near = [rival for rival, fit in instead if fit.score < model.score + INDISTINGUISHABLE]
    return SelectedEffect(one, float(share[0]), float(share[1]), without, tuple(near))


def _beside_functions(
    findings: Sequence[SelectedEffect], model: Fitted, functions: Sequence[At]
) -> Generator[Sets, Sequence[Fitted], list[SelectedEffect]]:
    """Findings, doubted where a function of unknown form explains the same, or makes them dispensable."""
    doubts = {one.at: 0.0 for one in findings}
    base = model
    while True:
        own = [at for at in base.effects if at in doubts]
        there = [one for one in functions if one not in base.effects]
        instead: list[tuple[At, tuple[At, ...]]] = [
            (at, (one,))
            for at in own
            for one in there
            if one.joint == at.joint and one.effect.name in at.effect.imitated_by
        ]
        instead += [(at, ()) for at in own if base is not model]
        fits = yield [(*(other for other in base.effects if other != at), *more) for at, more in instead]
        worse = [fit.worse_than(base) for fit in fits]
        for (at, _), by in zip(instead, worse, strict=True):
            doubts[at] = max(doubts[at], float(expit(-0.5 * by)))
        if min(worse, default=0.0) >= 0.0:
            return [one.doubted(1.0 - doubts[one.at]) for one in findings]
        base = fits[int(np.argmin(worse))]


def _reduced(model: Fitted, is_worth: Callable[[Fitted, Fitted], bool]) -> Generator[Sets, Sequence[Fitted], Fitted]:
    """A model without its dispensable effects."""
    while model.effects:
        fits = yield [tuple(other for other in model.effects if other != one) for one in model.effects]
        idle = [fit for fit in fits if fit.score < float("inf") and not is_worth(model, fit)]
        if not idle:
            break
        model = min(idle, key=_by_evidence)
    return model


def _rivals(one: At, model: Fitted, candidates: Sequence[At]) -> list[At]:
    """Candidates outside the model that may replace an effect."""
    return [
        other
        for other in candidates
        if other not in model.effects
        and (other.effect.name in one.effect.rivals or one.effect.name in other.effect.rivals)
        and (other.joint in _near(one) or other.effect.site != "joint" or one.effect.site != "joint")
    ]


def _near(one: At) -> range:
    """The joint of an effect, and its neighbours where the effect may be at a neighbouring link."""
    reach = int(one.effect.name in one.effect.rivals)
    return range(one.joint - reach, one.joint + reach + 1)


def side_by_side(fit: Fitting, searches: Sequence[EffectSearch]) -> list[Selection]:
    """Run searches of the same rows to their ends, and fit the models of their steps together."""
    requests: dict[int, Sets] = {number: next(one) for number, one in enumerate(searches)}
    found: dict[int, Selection] = {}
    while requests:
        fits = iter(fit([(number, effects) for number, sets in requests.items() for effects in sets]))
        following: dict[int, Sets] = {}
        for number, sets in requests.items():
            try:
                following[number] = searches[number].send([next(fits) for _ in sets])
            except StopIteration as end:
                found[number] = end.value
        requests = following
    return [found[number] for number in range(len(searches))]
