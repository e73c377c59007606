"""Solvers of somebody's own, good and bad, as they would lie in a current directory."""

import numpy as np


def halving(evaluator, seed):
    """Steps around the best point, half as long after each failure."""
    problem, rng = evaluator.problem, np.random.default_rng(seed)
    x, step, best = problem.sample_uniform(rng)[0], 0.5, np.inf
    while True:
        tries = x + step * (problem.upper - problem.lower) * rng.normal(size=(20, len(x)))
        tries = np.clip(tries, problem.lower, problem.upper)
        costs = evaluator.cost(tries)
        if costs.min() < best:
            x, best = tries[costs.argmin()], costs.min()
        else:
            step = max(step / 2, 1e-12)


def raising(evaluator, seed):
    """Finds something and breaks."""
    evaluator.cost(evaluator.problem.sample_uniform(np.random.default_rng(seed), 10))
    raise RuntimeError("out of ideas")


def not_a_number(evaluator, seed):
    """Asks what NaN costs."""
    evaluator.cost(np.full((1, evaluator.problem.dimension), np.nan))
