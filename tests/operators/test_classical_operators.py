"""The classical operators do what their authors say."""

import numpy as np
import pytest
from bowl import LOWER, UPPER, Bowl, population
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.mixed import MixedVariableDuplicateElimination, MixedVariableGA, MixedVariableMating
from pymoo.core.problem import ElementwiseProblem
from pymoo.core.variable import Integer, Real
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.operators.repair.rounding import RoundingRepair
from pymoo.optimize import minimize
from pymoo.problems import get_problem

from robolaser.errors import AlgorithmError
from robolaser.operators import (
    BlendCrossover,
    BoundaryMutation,
    ExtendedArithmeticCrossover,
    HeuristicCrossover,
    NonUniformMutation,
    RouletteSelection,
    SimpleCrossover,
    StochasticUniversalSampling,
    UniformMutation,
)
from robolaser.operators.scaling import SCALINGS, inverse_cost, linear_ranking, sigma_scaling, windowing

RNG = np.random.default_rng
COSTS = np.array([3.0, 1.0, 2.0, 5.0])


@pytest.mark.parametrize("scaling", [windowing, sigma_scaling, linear_ranking])
@pytest.mark.parametrize("zero", [0.0, 1e4, -1e4])
def test_scaled_weights_do_not_depend_on_the_costs_zero(scaling, zero):
    assert scaling(COSTS + zero) == pytest.approx(scaling(COSTS), abs=1e-9)


def test_the_papers_weights_do_depend_on_it():
    assert np.ptp(inverse_cost(COSTS)) > 0.7
    assert np.ptp(inverse_cost(COSTS + 1e4)) < 1e-3


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
    pop = population(Bowl(), 40)
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


def parents(n=4000, seed=0):
    rng = RNG(seed)
    return np.stack([rng.uniform(0.3, 0.4, (n, 3)), rng.uniform(0.5, 0.6, (n, 3))])


class Unit(type(get_problem("sphere"))):
    def __init__(self):
        super().__init__(n_var=3)
        self.xl, self.xu = np.zeros(3), np.ones(3)


def cross(operator, X=None, **kwargs):
    X = parents() if X is None else X
    return operator._do(Unit(), X, random_state=RNG(2), **kwargs), X


@pytest.mark.parametrize("alpha", [0.0, 0.5])
def test_blended_genes_fill_the_widened_span_evenly(alpha):
    children, (low, high) = cross(BlendCrossover(alpha))
    share = (children - (low - alpha * (high - low))) / ((1 + 2 * alpha) * (high - low))
    assert share.min() >= -1e-12
    assert share.max() <= 1 + 1e-12
    assert np.histogram(share, 10, (0, 1))[0] == pytest.approx(share.size / 10, rel=0.08)


def test_extended_children_lie_on_the_line_and_keep_the_sum():
    children, X = cross(ExtendedArithmeticCrossover(0.25))
    share = (children[0] - X[1]) / (X[0] - X[1])
    assert np.ptp(share, axis=1).max() < 1e-9
    assert share.min() == pytest.approx(-0.25, abs=0.01)
    assert share.max() == pytest.approx(1.25, abs=0.01)
    assert children.sum(axis=0) == pytest.approx(X.sum(axis=0))


def test_heuristic_children_lie_beyond_the_better_parent():
    n = parents().shape[1]
    costs = np.stack([np.zeros(n), np.ones(n)], axis=1)
    children, X = cross(HeuristicCrossover(), costs=costs)
    step = (children - X[0]) / (X[0] - X[1])
    assert step.min() >= 0.0
    assert step.max() <= 1.0
    swapped, _ = cross(HeuristicCrossover(), X[::-1], costs=costs[:, ::-1])
    assert np.array_equal(swapped, children)


def test_simple_crossover_exchanges_what_lies_behind_one_place():
    children, X = cross(SimpleCrossover())
    from_first = children[0] == X[0]
    assert np.all(np.diff(from_first.astype(int), axis=1) <= 0)
    assert np.all(from_first[:, 0])
    assert not np.any(from_first[:, -1])
    assert np.array_equal(np.sort(children, axis=0), np.sort(X, axis=0))


@pytest.mark.parametrize("mutation", [BoundaryMutation(prob_var=0.2), UniformMutation(prob_var=0.2)])
def test_so_many_genes_are_forgotten_as_is_said(mutation):
    pop = population(Bowl(), 2000)
    X = mutation.do(Bowl(), pop, inplace=False, random_state=RNG(3)).get("X")
    moved = X[:, 0] != pop.get("X")[:, 0]
    assert moved.mean() == pytest.approx(0.2, abs=0.05)
    if isinstance(mutation, BoundaryMutation):
        assert np.isin(X[moved, 0], [LOWER[0], UPPER[0]]).all()
    else:
        assert np.histogram(X[moved, 0], 4, (-1, 1))[0] == pytest.approx(moved.sum() / 4, rel=0.3)


@pytest.mark.parametrize("make", [lambda: BlendCrossover(-0.1), lambda: ExtendedArithmeticCrossover(delta=-1.0)])
def test_what_cannot_be_is_refused(make):
    with pytest.raises(AlgorithmError, match="at least 0"):
        make()


class Mixed(ElementwiseProblem):
    """One real variable and one integer."""

    def __init__(self):
        super().__init__(vars={"x": Real(bounds=(0, 1)), "k": Integer(bounds=(0, 5))}, n_obj=1)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = X["x"] + X["k"]


def test_a_heuristic_crossover_without_costs_says_so():
    operators = {Real: HeuristicCrossover(), Integer: SBX(vtype=float, repair=RoundingRepair())}
    mutations = {Real: PM(), Integer: PM(vtype=float, repair=RoundingRepair())}
    mating = MixedVariableMating(
        crossover=operators, mutation=mutations, eliminate_duplicates=MixedVariableDuplicateElimination()
    )
    with pytest.raises(AlgorithmError, match=r"HeuristicCrossover .* without their costs"):
        minimize(Mixed(), MixedVariableGA(pop_size=10, mating=mating), ("n_gen", 3), seed=1)
