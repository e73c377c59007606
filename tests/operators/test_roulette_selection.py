"""The roulette wheel gives everyone the share that his fitness is of the whole."""

import numpy as np
import pytest
from bowl import Bowl, population
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from scipy import stats

from robolaser.operators import RouletteSelection
from robolaser.operators.roulette_selection import inverse_cost, roulette_wheel

PROBLEM = Problem(n_var=1, n_obj=1, xl=0, xu=1)
INF, NAN = np.inf, np.nan


def selected(J, n, n_parents=2, G=None):
    J = np.asarray(J, np.float64)
    pop = Population.new(X=np.zeros((len(J), 1)), F=J[:, None])
    if G is not None:
        pop.set("G", np.asarray(G, np.float64)[:, None])
    return RouletteSelection().do(PROBLEM, pop, n, n_parents, to_pop=False, random_state=np.random.default_rng(8))


def test_frequencies_are_the_shares_of_fitness():
    J = np.array([1.0, 2.0, 0.5, 8.0, 3.0])
    counts = np.bincount(selected(J, 20_000).ravel(), minlength=5)
    assert stats.chisquare(counts, 40_000 * (1.0 / J) / (1.0 / J).sum()).pvalue > 0.01


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
    assert stats.chisquare(np.bincount(selected(J, 3000).ravel(), minlength=3)).pvalue > 0.01


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("J", "fitness"),
    [
        ([-INF, -1e308, 2.0], [1, 0, 0]),
        ([-1e308, 1e308, 1e308], [1, 0.5, 0.5]),
        ([-1.7e308, 1.7e308, 1.7e308, INF, 1.6e308], [1, 0.5, 0.5, 0, 1 / (1 + 3.3 / 3.4)]),
        ([-1e-300, -0.9e-300, -0.9e-300, 1e308], [1, 0.5, 0.5, 0]),
    ],
)
def test_extreme_costs_have_sensible_chances(J, fitness):
    np.testing.assert_allclose(inverse_cost(np.array(J)), fitness, rtol=1e-12)


def test_who_costs_minus_infinity_is_always_drawn():
    assert set(selected([-INF, 1.0, -1e308], 1000, G=[0.0, 0.0, 1.0]).ravel()) == {0}


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
