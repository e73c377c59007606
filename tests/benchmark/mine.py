"""Contestants of somebody's own, good and bad, as they would lie in a current directory."""

import numpy as np


def halving(watch, seed):
    """Steps around the best point, half as long after each failure."""
    question, rng = watch.question, np.random.default_rng(seed)
    x, step, best = question.anywhere(rng)[0], 0.5, np.inf
    while True:
        tries = x + step * (question.upper - question.lower) * rng.normal(size=(20, len(x)))
        tries = np.clip(tries, question.lower, question.upper)
        costs = watch.cost(tries)
        if costs.min() < best:
            x, best = tries[costs.argmin()], costs.min()
        else:
            step = max(step / 2, 1e-12)


def raising(watch, seed):
    """Finds something and breaks."""
    watch.cost(watch.question.anywhere(np.random.default_rng(seed), 10))
    raise RuntimeError("out of ideas")


def not_a_number(watch, seed):
    """Asks what NaN costs."""
    watch.cost(np.full((1, watch.question.dimension), np.nan))
