"""The cost of an individual as one number, from its objectives and constraints."""

from typing import Any

import numpy as np
from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting

from robolaser.arrays import Array


def of_population(pop: Any) -> Array:
    """Cost of each individual of a pymoo population, (n,).

    One objective is its own cost, infinite if it is not a number; of several it is the number of the non-dominated
    front, from 1. The cost of an infeasible individual is its violation above the worst feasible cost (Deb 2000), so it
    is never better than a feasible one of finite cost.
    """
    F, violation = pop.get("F"), pop.get("CV")[:, 0]
    cost = F[:, 0] if F.shape[1] == 1 else _front(F)
    cost = np.where(np.isnan(cost), np.inf, cost)
    keeps = violation <= 0.0
    kept = cost[keeps & np.isfinite(cost)]
    return np.where(keeps, cost, kept.max(initial=0.0) + violation)


def _front(F: Array) -> Array:
    _, rank = NonDominatedSorting().do(np.where(np.isnan(F), np.inf, F), return_rank=True)
    return np.asarray(rank + 1.0)
