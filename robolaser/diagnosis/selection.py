"""Which effects are in the model: added, exchanged and removed until nothing is gained any more."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.fitted import Fitted, Problem
from robolaser.diagnosis.signatures import Signature, signatures, typical
from robolaser.diagnosis.verdict import dispersion, price
from robolaser.effects.effect import Suspect

LEADERS = 6
"""Effects whose gain is checked by a full fit before one of them is added."""
EXCHANGED = 3
"""The same for each effect that is taken out to see whether another does better in its place."""
PAIRS = 4
"""Pairs of effects that are tried together: two may hide each other."""
IN_PAIRS = 24
"""Effects, best first, of which pairs are made."""
MOST = 12
"""Effects at most."""
FEW_STEPS = 40


@final
@dataclass
class Search:
    """Fits of all sets of suspects that were looked at.

    Attributes:
        start: The model without effects, fitted.
        suspects: What may be added.
    """

    start: Fitted
    suspects: Sequence[Suspect]
    tell: Callable[[str], None] = lambda what: None
    _fits: dict[frozenset[Suspect], Fitted] = field(default_factory=dict)
    _signatures: dict[frozenset[Suspect], list[Signature]] = field(default_factory=dict)
    _tried: dict[Suspect, int] = field(default_factory=dict)

    def fit(self, near: Fitted, added: Sequence[Signature] = (), removed: Suspect | None = None) -> Fitted:
        """Fit another set of suspects, starting from one that was fitted."""
        kept = tuple(suspect for suspect in near.suspects if suspect != removed)
        chosen = (*kept, *(signature.suspect for signature in added))
        key = frozenset(chosen)
        if key in self._fits:
            return self._fits[key]
        for signature in added:
            self._tried[signature.suspect] = signature.tried
        values = dict(zip(near.problem.parameters.names, near.x, strict=True))
        for signature in added:
            sizes = signature.amplitudes * typical(signature.suspect)
            values |= dict(zip(signature.suspect.parameters.names, (*sizes, *signature.shapes), strict=True))
        sensor = self.start.problem.sensor
        problem = Problem.of(self.start.problem.model.with_suspects(chosen), self.start.problem.noise, sensor)
        x = np.array([values[name] for name in problem.parameters.names])
        self._fits[key] = min(
            (problem.fit(problem.within(begin[None])[0], steps=FEW_STEPS) for begin in self._starts(problem, x)),
            key=lambda fit: fit.misfit,
        )
        return self._fits[key]

    def _starts(self, problem: Problem, x: Array) -> Iterator[Array]:
        yield x

    def signatures(self, fitted: Fitted) -> list[Signature]:
        """Of all suspects that it does not hold, best first."""
        key = frozenset(fitted.suspects)
        if key not in self._signatures:
            found = signatures(fitted, self.suspects)
            self._signatures[key] = sorted(found, key=lambda s: price(s.suspect, s.tried) - s.gain)
        return self._signatures[key]

    def price(self, fitted: Fitted) -> float:
        """What its effects must have gained, in squared whitened misfit."""
        return sum(price(suspect, self._tried.get(suspect, 1)) for suspect in fitted.suspects)

    def best(self) -> Fitted:
        """The set of effects that explains the most for its price."""
        state = self.start
        while True:
            self.tell("looking for effects")
            options = [self.fit(state, [s]) for s in self.signatures(state)[:LEADERS]] if len(state.suspects) < MOST else []
            options += [self.fit(state, pair) for pair in _pairs(self.signatures(state))]
            for suspect in state.suspects:
                less = self.fit(state, removed=suspect)
                options += [less, *(self.fit(less, [s]) for s in self.signatures(less)[:EXCHANGED])]
            spread = dispersion(min([state, *options], key=lambda fit: fit.misfit))

            def cost(fit: Fitted, spread: float = spread) -> float:
                return fit.misfit / spread + self.price(fit)

            better = min(options, key=cost, default=state)
            if not cost(better) < cost(state) - 1e-6:
                return state
            state = better


def _pairs(found: Sequence[Signature]) -> list[tuple[Signature, Signature]]:
    """The pairs that together promise the most beyond their price, where that is more than either alone does."""
    some = found[:IN_PAIRS]
    options = []
    for i, one in enumerate(some):
        for other in some[:i]:
            both = np.linalg.svd(np.hstack([one.basis, other.basis]), full_matrices=False)
            basis = both[0][:, both[1] > 1e-3]
            gain = float(((basis.T @ one.rest) ** 2).sum())
            options.append((price(one.suspect, one.tried) + price(other.suspect, other.tried) - gain, one, other))
    options.sort(key=lambda option: option[0])
    return [(one, other) for _, one, other in options[:PAIRS]]
