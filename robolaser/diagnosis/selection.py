"""Which effects are in the model: added, exchanged and removed until nothing is gained any more."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import final

import numpy as np

from robolaser.diagnosis.localization import explained
from robolaser.diagnosis.penalized_fit import Fitted, Problem
from robolaser.diagnosis.score_tests import Signature, Slopes, afresh, best_steps, signatures, typical
from robolaser.diagnosis.verdict import BELIEVED, PRIOR_UNKNOWN, dispersion, price
from robolaser.model.effects.effect import CandidateEffect

LEADERS = 4
"""Effects whose gain is checked by a full fit before one of them is added."""
EXCHANGED = 2
"""The same for each effect that is taken out to see whether another does better in its place."""
PAIRS = 2
"""Pairs of effects that are tried together: two may hide each other."""
IN_PAIRS = 16
"""Effects, best first, of which pairs are made."""
SEEN_APART = 1e-2
"""Sine of the angle between two effects' signatures, below which they are one."""
WORTH = 25.0
"""Squared whitened misfit by which a pair must promise more than its better half at once with the price paid."""
NEAR = 0.75
"""Share of the largest gain that an effect must promise to be worth a full fit."""
LIKELIEST = 3
"""Additions, best first, that are held against something unknown before no effect is added."""
LEAST_GAIN = 1e-3
"""A smaller change of the cost is none."""
MOST_EXCHANGED = 4
"""Effects in a model, up to which exchanges are tried: with more, the library is making do without the cause."""
MOST = 8
"""Effects at most."""


@final
@dataclass
class Search:
    """Fits of all sets of candidate_effects that were looked at.

    Attributes:
        start: The model without effects, fitted.
        candidate_effects: What may be added.
    """

    start: Fitted
    effects: Sequence[CandidateEffect]
    tell: Callable[[str], None] = lambda what: None
    _fits: dict[frozenset[CandidateEffect], Fitted] = field(default_factory=dict)
    _signatures: dict[frozenset[CandidateEffect], list[Signature]] = field(default_factory=dict)
    _begun: set[tuple[frozenset[CandidateEffect], tuple[object, ...]]] = field(default_factory=set)
    _unknown: dict[frozenset[CandidateEffect], tuple[float, float]] = field(default_factory=dict)
    _slopes: Slopes = field(default_factory=Slopes)
    _spread: float = np.inf
    _found: dict[CandidateEffect, Signature] = field(default_factory=dict)

    def fit(self, near: Fitted, added: Sequence[Signature] = (), removed: CandidateEffect | None = None) -> Fitted:
        """Fit another set of candidate_effects, starting from one that was fitted."""
        kept = tuple(candidate_effect for candidate_effect in near.effects if candidate_effect != removed)
        chosen = (*kept, *(signature.candidate_effect for signature in added))
        key = frozenset(chosen)
        begun = tuple(
            sorted(
                (signature.candidate_effect.effect.name, signature.candidate_effect.where, signature.shapes)
                for signature in added
            )
        )
        if key in self._fits and (not added or (key, begun) in self._begun):
            return self._fits[key]
        self._begun.add((key, begun))
        self._found |= {signature.candidate_effect: signature for signature in added}
        values = dict(zip(near.problem.parameters.names, near.x, strict=True))
        if added:
            values |= _promised(near, added)
        sensor = self.start.problem.sensor
        problem = Problem.of(self.start.problem.model.with_effects(chosen), self.start.problem.noise, sensor)
        x = np.array([values[name] for name in problem.parameters.names])
        fitted = problem.fit(problem.within(x[None])[0])
        if key not in self._fits or fitted.misfit < self._fits[key].misfit:
            self._fits[key] = fitted
        return self._fits[key]

    def settled(self, state: Fitted) -> Fitted:
        """The same effects, the shapes of each sought anew now that the others are known."""
        for candidate_effect in state.effects[:-1]:
            if candidate_effect.effect.nonlinear_parameters() and len(state.effects) > 1:
                less = self.fit(state, removed=candidate_effect)
                state = min(
                    state,
                    self.fit(less, signatures(less, [candidate_effect], self._slopes)),
                    key=lambda fit: fit.misfit,
                )
        return state

    def signatures(self, fitted: Fitted) -> list[Signature]:
        """Of all candidate_effects that it does not hold, best first."""
        key = frozenset(fitted.effects)
        if key not in self._signatures:
            found = signatures(fitted, self.effects, self._slopes)
            self._signatures[key] = sorted(found, key=lambda s: price(s.candidate_effect, s.tried) - s.gain)
        return self._signatures[key]

    def seen(self, fitted: Fitted) -> list[Signature]:
        """The signatures by which the effects of a fitted model were found, with its own shapes."""
        return [self._found[candidate_effect] for candidate_effect in fitted.effects]

    def price(self, fitted: Fitted) -> float:
        """What its effects must have gained, in squared whitened misfit."""
        return sum(price(candidate_effect, self._found[candidate_effect].tried) for candidate_effect in fitted.effects)

    def cost(self, fitted: Fitted, spread: float) -> float:
        """Misfit, in units of how much whole poses scatter, and the price of the effects."""
        return fitted.misfit / spread + self.price(fitted)

    def strange(self, fitted: Fitted, without: Fitted) -> float:
        """Probability that something unknown explains what some effects do, with no need of them.

        Functions of any form at any site stand for the unknown, beside the effects and in their place. Seen by a
        tracker or by sockets, any effect of the arm is such a function of the posture, and they say nothing against it.
        """
        if self.start.problem.model.dataset.kind != "stripe":
            return 0.0
        apart = self._beside_unknown(without) + PRIOR_UNKNOWN - self._beside_unknown(fitted)
        return float(1.0 / (1.0 + np.exp(np.clip(0.5 * apart, -700.0, 700.0))))

    def _beside_unknown(self, fitted: Fitted) -> float:
        key = frozenset(fitted.effects)
        if key not in self._unknown or self._unknown[key][0] != fitted.misfit:
            self._unknown[key] = fitted.misfit, self.cost(fitted, 1.0) - explained(fitted)
        return self._unknown[key][1]

    def again(self, earlier: Fitted, found: "Search") -> Fitted:
        """Fit the effects that a search on slightly other rows found."""
        self._found |= {signature.candidate_effect: afresh(signature, self.start) for signature in found.seen(earlier)}
        model = self.start.problem.model.with_effects(earlier.effects)
        problem = Problem.of(model, self.start.problem.noise, self.start.problem.sensor)
        fitted = problem.fit(earlier.x)
        self._fits[frozenset(earlier.effects)] = fitted
        return fitted

    def best(self, begin: Fitted | None = None, most: int = MOST) -> Fitted:
        """The set of effects that explains the most for its price.

        Effects are added while that pays; then each is taken out, or exchanged for another; then again. All are judged
        by the least scatter of poses that any set has left so far, so that no step is ever taken back for another's.
        Where something unknown explains what is left with no need of another effect, none is added.
        """
        state = begin or self.start
        while True:
            likely = self._better(state, self._additions(state, most))[:LIKELIEST]
            chosen = next((fit for fit in map(self.settled, likely) if self.strange(fit, state) <= BELIEVED), None)
            if chosen is None and len(state.effects) <= MOST_EXCHANGED:
                chosen = next(map(self.settled, self._better(state, self._exchanges(state))), None)
            if chosen is None:
                return state
            state = chosen
            self._slopes = Slopes()

    def _better(self, state: Fitted, options: Sequence[Fitted]) -> list[Fitted]:
        """Those that cost less, the least first."""
        self._spread = spread = min([self._spread, *map(dispersion, [state, *options])])
        least = self.cost(state, spread) - LEAST_GAIN
        return sorted(
            (fit for fit in options if self.cost(fit, spread) < least), key=lambda fit: self.cost(fit, spread)
        )

    def _additions(self, state: Fitted, most_effects: int) -> list[Fitted]:
        if len(state.effects) >= most_effects:
            return []
        self.tell(f"adding effects to {len(state.effects)}")
        found = self.signatures(state)
        most = max((s.gain for s in found), default=0.0)
        leaders = [s for s in found[:LEADERS] if s.gain > max(NEAR * most, LEAST_GAIN)]
        return [self.fit(state, [s]) for s in leaders] + [self.fit(state, pair) for pair in _pairs(found)]

    def _exchanges(self, state: Fitted) -> list[Fitted]:
        self.tell(f"exchanging {len(state.effects)} effects")
        options = []
        for candidate_effect in state.effects:
            less = self.fit(state, removed=candidate_effect)
            lost = less.misfit - state.misfit
            options.append(less)
            rivals = [s for s in self.signatures(less)[:EXCHANGED] if s.gain > NEAR * lost]
            options += [self.fit(less, [s]) for s in rivals]
        return options


def _promised(near: Fitted, added: Sequence[Signature]) -> dict[str, float]:
    """Where the linear model puts all parameters once effects are added, by name."""
    white = np.hstack([signature.white for signature in added])
    columns = np.hstack([near.projected(white), near.inward])
    amplitudes = best_steps(columns, near.rest)[: white.shape[1]]
    moved = near.x + near.problem.prior * near.step(near.r + white @ amplitudes)
    values = dict(zip(near.problem.parameters.names, moved.tolist(), strict=True))
    at = 0
    for signature in added:
        size = typical(signature.candidate_effect)
        numbers = (*(amplitudes[at : at + len(size)] * size), *signature.shapes)
        values |= dict(zip(signature.candidate_effect.parameters.names, numbers, strict=True))
        at += len(size)
    return values


def _pairs(found: Sequence[Signature]) -> list[tuple[Signature, Signature]]:
    """Pairs that together promise far more than either does alone: the halves of which hide each other."""
    some = found[:IN_PAIRS]
    if len(some) < 2:
        return []
    alone = max(one.gain - price(one.candidate_effect, one.tried) for one in some)
    options = []
    for i, one in enumerate(some):
        for other in some[:i]:
            U, s, _ = np.linalg.svd(np.hstack([one.basis, other.basis]), full_matrices=False)
            gain = float(((U[:, s > SEEN_APART].T @ one.against.rest) ** 2).sum())
            worth = gain - price(one.candidate_effect, one.tried) - price(other.candidate_effect, other.tried)
            if worth > max(alone, 0.0) + WORTH:
                options.append((worth, i, one, other))
    options.sort(key=lambda option: option[:2], reverse=True)
    return [(one, other) for _, _, one, other in options[:PAIRS]]
