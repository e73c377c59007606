"""The global optimum within the bounds, with only a seed to choose: sample, descend, agree.

Random points within the bounds are cheap, and the best of some hundreds is nearly always in the optimum's basin of
attraction. So a few of each round are refined, until descents from different points end at the same lowest cost.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data import subsampling
from robolaser.errors import UsageError
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.forward_model import Model

SEARCH_POINTS = 200  # rows, about, of the subsample that is searched on: it ranks candidates as the whole does
SEARCH_POSES = 200  # poses of it at most, evenly taken, where rows have no names: each keeps three rows
CANDIDATES = 256  # sampled in a round
STARTS = 4  # candidates of a round that are refined
AGREEING = 3  # descents that must end at the same lowest cost before it counts as found
FIRST_ROUND = 2  # times as many of both in the first round, whose descents run together
MOST_ROUNDS = 49
PATIENCE = 2  # times the steps of the agreeing after which a descent that is still above them is given up
SAME = 1e-6  # relative difference of cost below which two optima are one
NOTHING_M2 = 1e-18  # two costs whose difference is below this are one: a nanometre altogether
TOLERANCE = 1e-10


@final
@dataclass(frozen=True, eq=False)
class Optimum:
    """The lowest cost found."""

    x: Array  # where, (d,)
    cost: float  # J of all rows there [m²]; infinite where all candidates are at poles
    evaluations: int  # candidates evaluated
    descents: int  # how many were refined
    agreeing: int  # how many of them ended there


def multistart(
    model: Model, *, seed: int, starts: Array | None = None, progress: Callable[[float, int, Array], None] | None = None
) -> Optimum:
    """Find the lowest J of a model within its bounds.

    Args:
        model: Any; many rows are searched on subsampled, see `subsampled`.
        seed: Of the candidates.
        starts: Candidates that are refined before any are sampled, (k, d); the nominal values by default.
        progress: Called twice a round with the finished share of the most rounds, the candidates evaluated, and the
            best one by the rows searched on: of the round's samples, then of all that were refined.
    """
    announce = progress or (lambda share, evaluations, x: None)
    rng = np.random.default_rng(seed)
    problem = Problem.of(subsampled(model))
    starts = model.parameters.nominal[None] if starts is None else starts
    ends, costs, evaluations, agreeing = np.empty((0, len(problem.scale))), np.empty(0), 0, 0
    for round_number in range(MOST_ROUNDS):
        times = 1 if round_number else FIRST_ROUND
        x = _sampled(problem, rng, times)
        evaluations += times * CANDIDATES
        announce(round_number / MOST_ROUNDS, evaluations, x[0])
        more_ends, more_costs, evaluated = _descended(problem, x if round_number else np.vstack([starts, x]))
        ends, costs = np.vstack([ends, more_ends]), np.append(costs, more_costs)
        evaluations += evaluated
        announce((round_number + 1) / MOST_ROUNDS, evaluations, ends[int(np.argmin(costs))])
        agreeing = int(_same(costs, costs.min()).sum())
        if agreeing >= AGREEING and np.isfinite(costs.min()):
            break
    x = ends[int(np.argmin(costs))]
    return Optimum(x, float(model.cost(x[None])[0]), evaluations, len(ends), agreeing)


def subsampled(model: Model) -> Model:
    """The model of enough rows to search on; itself where it has no more."""
    few = subsampling.subsampled(model.dataset, SEARCH_POINTS)
    poses = np.unique(few.points.pose)
    if len(poses) > SEARCH_POSES and not few.format.named_points:
        some = poses[subsampling.evenly(len(poses), SEARCH_POSES)]
        few = replace(few, points=few.points.take(np.flatnonzero(np.isin(few.points.pose, some))))
    return model if few is model.dataset else Model(few, model.effects).sharing(model.sensor_parameters)


def _sampled(problem: Problem, rng: np.random.Generator, times: int) -> Array:
    """The best of random candidates, (times STARTS, d) of times CANDIDATES.

    In half of them effects are at their nominal values. Parameters that the sensor derives from the others start there.
    """
    model, parameters = problem.model, problem.parameters
    x = problem.lower + rng.random((times * CANDIDATES, len(parameters))) * (problem.upper - problem.lower)
    x[::2, len(parameters) - len(model.effect_parameters) :] = model.effect_parameters.nominal
    values = model.completed(parameters.values(x))
    x = np.stack([values[name] for name in parameters.names], axis=1)
    x = np.clip(x, problem.lower, problem.upper)
    return np.asarray(x[np.argsort(problem.costs(x), kind="stable")[: times * STARTS]])


def _descended(problem: Problem, starts: Array) -> tuple[Array, Array, int]:
    """The ends of starts (k, d), their costs (k,), and the candidates evaluated."""
    starts = np.array([problem.model.fix_gauge(start) for start in starts]).reshape(starts.shape)
    ends = solve(problem, starts, tol=TOLERANCE, hopeless=_hopeless)
    return ends.x, ends.cost, ends.evaluations


def _hopeless(costs: Array, converged: Bools, steps: Ints) -> Bools:
    """Descents (c,) that are above the cost on which enough agree, long after these have ended."""
    ended = steps[converged & _same(costs, costs.min())]
    if len(ended) < AGREEING:
        return np.zeros(len(costs), dtype=bool)
    return np.asarray(~_same(costs, costs.min()) & (steps >= PATIENCE * np.sort(ended)[AGREEING - 1]))


def _same(costs: Array, lowest: float) -> Bools:
    """Which costs (c,) are as good as the lowest one."""
    return np.asarray(costs <= lowest * (1.0 + SAME) + NOTHING_M2)


def check_bounds(model: Model, what: str) -> None:
    """Check that all searched parameters have bounds, for a search such as "--algorithm rcga".

    Raises:
        UsageError: Some have none.
    """
    names = model.sensor_parameters.unbounded(model.blocks.free)
    if names:
        raise UsageError(
            f"{what} searches within bounds, but dataset.toml gives none for {', '.join(names)}: these start from"
            " closed forms. State { nominal, lower, upper } for each under [parameters], or calibrate without a search."
        )
