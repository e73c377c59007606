"""RCGA on variables that are whole numbers: rounded where it is asked for, else refused."""

import numpy as np
import pytest
from pymoo.core.problem import Problem
from pymoo.operators.repair.rounding import RoundingRepair
from pymoo.optimize import minimize

from robolaser.algorithms import RCGA
from robolaser.arrays import Array
from robolaser.errors import AlgorithmError


class Whole(Problem):
    def __init__(self) -> None:
        super().__init__(n_var=3, n_obj=1, xl=0, xu=20, vtype=int)

    def _evaluate(self, X: Array, out: dict[str, Array], *args: object, **kwargs: object) -> None:
        out["F"] = np.square(X - 7.0).sum(axis=1, keepdims=True)


def test_whole_numbers_are_refused() -> None:
    with pytest.raises(AlgorithmError, match="RoundingRepair"):
        minimize(Whole(), RCGA(), ("n_gen", 2), seed=1)


def test_with_a_repair_that_rounds_they_stay_whole() -> None:
    assert minimize(Whole(), RCGA(repair=RoundingRepair()), ("n_gen", 60), seed=1).X.tolist() == [7, 7, 7]
