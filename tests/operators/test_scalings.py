"""The wheel weighs as its authors say, and a turn of it with equal marks is fair."""

import numpy as np
import pytest
from bowl import Bowl, population
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.optimize import minimize
from pymoo.problems import get_problem

from robolaser.errors import AlgorithmError
from robolaser.operators import NonUniformMutation, RouletteSelection, StochasticUniversalSampling
from robolaser.operators.scaling import SCALINGS, linear_ranking, sigma_scaling, windowing

RNG = np.random.default_rng
COSTS = np.array([3.0, 1.0, 2.0, 5.0])


@pytest.mark.parametrize("scaling", [windowing, sigma_scaling, linear_ranking])
@pytest.mark.parametrize("zero", [0.0, 1e4, -1e4])
def test_scaled_weights_do_not_depend_on_the_costs_zero(scaling, zero):
    assert scaling(COSTS + zero) == pytest.approx(scaling(COSTS), abs=1e-9)


@pytest.mark.parametrize("scaling", SCALINGS.values(), ids=SCALINGS)
def test_better_costs_never_weigh_less_and_bad_numbers_nothing(scaling):
    costs = np.array([1.0, 2.0, np.nan, 4.0, np.inf, 4.0])
    weights = scaling(costs)
    assert np.all(weights >= 0.0)
    assert weights[2] == weights[4] == 0.0
    assert weights[0] >= weights[1] >= weights[3] == weights[5]
    assert weights[0] > weights[3]


@pytest.mark.parametrize("scaling", SCALINGS.values(), ids=SCALINGS)
@pytest.mark.parametrize(
    "costs", [[np.inf, np.nan, np.inf], [2.0, 2.0, 2.0], [4.0]], ids=["none finite", "alike", "one"]
)
def test_there_is_always_somebody_to_choose(scaling, costs):
    weights = scaling(np.array(costs))
    assert np.all(np.isfinite(weights))
    assert weights.sum() > 0.0


def test_known_values_of_the_scalings():
    assert windowing(COSTS).tolist() == [2.0, 4.0, 3.0, 0.0]
    assert linear_ranking(COSTS) == pytest.approx([2 / 3, 2.0, 4 / 3, 0.0])
    assert linear_ranking(np.array([1.0, 1.0, 7.0])).tolist() == [1.5, 1.5, 0.0]
    assert sigma_scaling(COSTS)[1] == pytest.approx(1.0 + (COSTS.mean() - 1.0) / (2.0 * COSTS.std()))
    assert sigma_scaling(np.array([0.0] * 50 + [1e6]))[-1] == 0.1


def test_an_unknown_scaling_is_refused_with_those_there_are():
    with pytest.raises(AlgorithmError, match="inverse, windowing, sigma, ranking"):
        RouletteSelection(scaling="linear")


def test_one_turn_chooses_each_as_often_as_its_weight_says_up_to_one():
    pop = population(40)
    chosen = StochasticUniversalSampling("ranking").do(Bowl(), pop, 50, 2, to_pop=False, random_state=RNG(1))
    weights = linear_ranking(pop.get("F")[:, 0])
    counts = np.bincount(chosen.ravel(), minlength=40)
    assert np.all(np.abs(counts - 100 * weights / weights.sum()) < 1.0)


def test_a_roulette_that_ranks_finds_as_well_whatever_is_added_to_the_cost():
    class Raised(type(get_problem("rastrigin"))):
        def _evaluate(self, X, out, *args, **kwargs):
            super()._evaluate(X, out, *args, **kwargs)
            out["F"] = np.round(out["F"] * 2**20) / 2**20 + self.zero

    def excess(zero, scaling):
        problem = Raised(n_var=10)
        problem.zero = zero
        algorithm = GA(40, selection=RouletteSelection(scaling), mutation=NonUniformMutation())
        return minimize(problem, algorithm, ("n_gen", 60), seed=4).F[0] - zero

    assert excess(2.0**20, "ranking") == pytest.approx(excess(0.0, "ranking"), abs=1e-9)
    assert excess(2.0**20, "inverse") != pytest.approx(excess(0.0, "inverse"), rel=0.1)
