"""The cost of an individual as one number, from its objectives and constraints."""

import math
from typing import Any

import numpy as np
from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting

from robolaser.arrays import Array


def penalised(cost: Array, violation: Array | None = None) -> Array:
    """Add the violation of constraints to the worst cost that keeps them, (n,), (n,) -> (n,). Deb 2000.

    So no individual that violates a constraint is better than one of finite cost that keeps them. A cost that is
    not a number is infinite. No violation: there are no constraints.
    """
    if math.isnan(cost.min()):
        cost = np.where(np.isnan(cost), np.inf, cost)
    if violation is None:
        return cost
    keeps = violation <= 0.0
    if keeps.all():
        return cost
    kept = cost[keeps & np.isfinite(cost)]
    return np.where(keeps, cost, kept.max(initial=0.0) + violation)


def of_population(pop: Any) -> Array:
    """Cost of each individual of a pymoo population, (n,).

    One objective is its own cost; of several it is the number of the non-dominated front, from 1.
    """
    F, violation = pop.get("F"), pop.get("CV")[:, 0]
    return penalised(F[:, 0] if F.shape[1] == 1 else _front(F), violation)


def _front(F: Array) -> Array:
    fronts = NonDominatedSorting().do(np.where(np.isnan(F), np.inf, F))
    number = np.empty(len(F))
    for i, front in enumerate(fronts):
        number[front] = i + 1
    return number
