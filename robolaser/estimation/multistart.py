"""The global optimum of J, with nothing to choose but a seed: screen, descend, agree.

Random candidates of the reduction are cheap, and the best of some hundreds nearly always lies in the optimum's valley.
So a few of each round go downhill, and rounds go on until descents from different candidates have ended at the same
lowest J.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.compiled import available
from robolaser.estimation.problem import Box, Residuals
from robolaser.estimation.reduction import Reduction
from robolaser.model.forward_model import Model
from robolaser.model.sensors import Stripe

SEARCH_POINTS = 200
"""Rows, about, of the thinned set that is searched on: it ranks candidates as the whole does."""
CANDIDATES = 256
"""Screened in a round: on eleven calibrations the best of so many leads to the optimum in 78 to 100 % of rounds."""
STARTS = 4
"""Candidates of a round that go downhill."""
AGREEING = 3
"""Descents that must end at the same lowest J before it counts as found."""
FEWEST_ROUNDS, MOST_ROUNDS = 2, 50
SAME = 1e-6
"""Relative difference of J below which two optima are one."""
NOTHING_M2 = 1e-18
"""Two J whose difference is below this are one: a nanometre altogether."""
STEPS = 1000
"""Of a descent at most; 100 are usual, few points leave long bent valleys."""
TOLERANCE = 1e-10
MOST_ROWS = 20_000
"""Up to so many rows the descent goes on on all of them: their derivatives need 7 MB."""


@final
@dataclass(frozen=True, eq=False)
class Optimum:
    """The lowest J that was found.

    Attributes:
        x: Where, (d,).
        cost: J there [m²]; infinite where all candidates lie at poles.
        evaluations: Candidates evaluated.
        descents: How many went downhill.
        agreeing: How many of them ended there.
    """

    x: Array
    cost: float
    evaluations: int
    descents: int
    agreeing: int


@final
@dataclass(frozen=True, eq=False)
class SoFar:
    """How far the search has come.

    Attributes:
        share: Of the rounds that it may take.
        evaluations: Candidates evaluated.
        x: The best of the round's candidates, then of all that have gone downhill, (d,), by the J of the rows that are
            searched on.
    """

    share: float
    evaluations: int
    x: Array


def optimum(
    model: Model, *, seed: int, starts: Array | None = None, progress: Callable[[SoFar], None] = lambda so_far: None
) -> Optimum:
    """Find the lowest J of a model within its bounds.

    Args:
        model: Any; many rows are searched on thinned, see `Dataset.thinned`.
        seed: Makes the candidates.
        starts: Candidates that go downhill before any are screened, (k, d); the nominal values by default.
        progress: Is told after their descents, if there are any, and twice in each round.
    """
    rng = np.random.default_rng(seed)
    thin = thinned(model)
    reduction = Reduction(thin)
    starts = model.parameters.nominal[None] if starts is None else starts
    ends, costs, evaluations = _descended(thin, starts)
    agreeing = 0
    if len(ends):
        progress(SoFar(0.0, evaluations, ends[int(np.argmin(costs))]))
    for turn in range(MOST_ROUNDS):
        x = _screened(reduction, rng)
        progress(SoFar(turn / MOST_ROUNDS, evaluations + CANDIDATES, x[0]))
        more_ends, more_costs, evaluated = _descended(thin, x)
        ends, costs = np.vstack([ends, more_ends]), np.append(costs, more_costs)
        evaluations += evaluated + CANDIDATES
        progress(SoFar((turn + 1) / MOST_ROUNDS, evaluations, ends[int(np.argmin(costs))]))
        agreeing = int((costs <= costs.min() * (1.0 + SAME) + NOTHING_M2).sum())
        if agreeing >= AGREEING and turn + 1 >= FEWEST_ROUNDS and np.isfinite(costs.min()):
            break
    x = ends[int(np.argmin(costs))]
    if thin is not model and _is_compiled(model) and len(model.dataset.points) <= MOST_ROWS:
        arrived, _, evaluated = _descended(model, x[None])
        x, evaluations = arrived[0], evaluations + evaluated
    return Optimum(x, float(model.cost(x[None])[0]), evaluations, len(ends), agreeing)


def thinned(model: Model) -> Model:
    """The model of rows enough to search on; itself where it has no more."""
    few = model.dataset.subsampled(SEARCH_POINTS)
    return model if few is model.dataset else Model(few, model.effects)


def _screened(reduction: Reduction, rng: np.random.Generator) -> Array:
    """The best of a round of random candidates, (STARTS, d). In half of them effects are at their nominal values."""
    model, free = reduction.model, reduction.parameters
    z = free.lower + rng.random((CANDIDATES, len(free))) * free.width
    of_effects = [name in model.effect_parameters.names for name in free.names]
    z[::2, of_effects] = free.nominal[of_effects]
    x = reduction.completed(z)
    return x[np.argsort(model.cost(x), kind="stable")[:STARTS]]


def _is_compiled(model: Model) -> bool:
    """Whether descents of a model are compiled."""
    return isinstance(model.sensor, Stripe) and not model.effects and available()


def _descended(model: Model, starts: Array) -> tuple[Array, Array, int]:
    """Where starts end (k, d), J there (k,), and the candidates evaluated."""
    box = Box.of(model)
    held = np.array([model.fix_gauge(start) for start in starts]).reshape(starts.shape)
    starts = np.clip(held, box.lower, box.upper)
    sensor = model.sensor
    if isinstance(sensor, Stripe) and _is_compiled(model):
        return sensor.chain.descend(starts, box.lower, box.upper, model.flange({}), steps=STEPS, tol=TOLERANCE)
    polished = [box.polish(Residuals(model), start, tol=TOLERANCE) for start in starts]
    ends = np.array([one.x for one in polished]).reshape(starts.shape)
    costs = np.array([one.cost for one in polished])
    return ends, costs, sum(one.evaluations for one in polished)
