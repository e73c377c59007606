"""The roulette wheel gives everyone the share that his fitness is of the whole."""

import numpy as np
import pytest
from bowl import Bowl, population
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from pymoo.problems import get_problem
from scipy import stats

from robolaser.errors import AlgorithmError
from robolaser.operators import NonUniformMutation, RouletteSelection, StochasticUniversalSampling
from robolaser.operators.roulette_selection import (
    SCALINGS,
    inverse_cost,
    linear_ranking,
    roulette_wheel,
    sigma_scaling,
    windowing,
)

PROBLEM = Problem(n_var=1, n_obj=1, xl=0, xu=1)
INF, NAN = np.inf, np.nan
RNG = np.random.default_rng
COSTS = np.array([3.0, 1.0, 2.0, 5.0])


def selected(J, n, n_parents=2, G=None):
    J = np.asarray(J, np.float64)
    pop = Population.new(X=np.zeros((len(J), 1)), F=J[:, None])
    if G is not None:
        pop.set("G", np.asarray(G, np.float64)[:, None])
    return RouletteSelection().do(PROBLEM, pop, n, n_parents, to_pop=False, random_state=np.random.default_rng(8))


def test_frequencies_are_the_shares_of_fitness():
    J = np.array([1.0, 2.0, 0.5, 8.0, 3.0])
    counts = np.bincount(selected(J, 20_000).ravel(), minlength=5)
    expected = 40_000 * (1.0 / J) / (1.0 / J).sum()
    assert stats.chisquare(counts, expected).pvalue > 0.01


def test_the_first_and_the_second_parent_are_drawn_independently():
    a, b = selected([1.0, 2.0, 4.0], 20_000).T
    table = np.zeros((3, 3))
    np.add.at(table, (a, b), 1)
    assert stats.chi2_contingency(table).pvalue > 0.01


@pytest.mark.parametrize("unit", [1e-300, 1e-9, 1e12, 1e300])
def test_the_unit_of_the_cost_does_not_matter(unit):
    J = np.array([1.0, 2.0, 5.0, 0.25])
    np.testing.assert_allclose(inverse_cost(unit * J), inverse_cost(J), rtol=1e-12)


def test_a_perfect_individual_leaves_nothing_to_the_others():
    assert set(selected([3.0, 0.0, 1e-300, 0.0], 1000).ravel()) == {1, 3}


@pytest.mark.parametrize(
    "J", [[INF, INF, INF], [NAN, INF, NAN], [-INF, -INF, -INF], [-3.0, -3.0, -3.0], [0.0, 0.0, 0.0]]
)
def test_where_all_are_alike_all_have_the_same_chance(J):
    counts = np.bincount(selected(J, 3000).ravel(), minlength=3)
    assert stats.chisquare(counts).pvalue > 0.01


def test_negative_costs_count_from_the_best():
    J = np.array([-10.0, -9.0, -8.0, -4.0])
    np.testing.assert_allclose(inverse_cost(J), inverse_cost(J - 50.0))
    np.testing.assert_allclose(inverse_cost(J), inverse_cost(1e6 * J))
    assert np.all(np.diff(inverse_cost(J)) < 0)
    assert inverse_cost(np.array([-INF, -1.0, 5.0])).tolist() == [1.0, 0.0, 0.0]
    assert inverse_cost(np.array([-1.0, INF, 5.0]))[1] == 0.0


def test_the_wheel_has_no_gap_and_no_overlap():
    weights = np.array([0.0, 1.0, 0.0, 3.0, 0.0])
    assert roulette_wheel(weights, np.array([0.0, 0.2499, 0.25, np.nextafter(1.0, 0.0)])).tolist() == [1, 1, 3, 3]
    rng = np.random.default_rng(10)
    for _ in range(200):
        weights = np.append(rng.random(9), 0.0)
        assert roulette_wheel(weights, np.nextafter(1.0, 0.0)) == 8


def test_whoever_violates_a_constraint_is_no_better_than_the_worst_who_keeps_them():
    counts = np.bincount(selected([1.0, 4.0, 0.1, 0.2], 20_000, G=[-1.0, -1.0, 2.0, 4.0]).ravel(), minlength=4)
    expected = 1.0 / np.array([1.0, 4.0, 6.0, 8.0])
    assert stats.chisquare(counts, 40_000 * expected / expected.sum()).pvalue > 0.01


def test_where_all_violate_constraints_the_least_violation_has_the_best_chance():
    counts = np.bincount(selected([9.0, 4.0, 0.1], 20_000, G=[1.0, 2.0, 4.0]).ravel(), minlength=3)
    assert stats.chisquare(counts, 40_000 * np.array([4.0, 2.0, 1.0]) / 7.0).pvalue > 0.01


def test_with_several_objectives_the_first_front_has_the_best_chance():
    problem = Bowl(n_obj=2)
    pop = population(30)
    pop.set("F", np.stack([np.repeat([1.0, 2.0, 3.0], 10), np.repeat([1.0, 2.0, 3.0], 10)], axis=1))
    parents = RouletteSelection().do(problem, pop, 5000, 2, to_pop=False, random_state=np.random.default_rng(11))
    counts = np.bincount(parents.ravel() // 10, minlength=3)
    assert stats.chisquare(counts, 10_000 * np.array([6.0, 3.0, 2.0]) / 11.0).pvalue > 0.01


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
