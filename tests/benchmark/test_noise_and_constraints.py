"""Noise is noticed and nobody wins by luck; constraints and kinds of variables reach the algorithms as they are."""

import numpy as np
import pytest
from mine import Constrained, Noisy, Whole
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.algorithms.soo.nonconvex.isres import ISRES
from pymoo.core.mixed import MixedVariableGA
from pymoo.core.problem import ElementwiseProblem
from pymoo.core.variable import Binary, Integer, Real
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.operators.repair.rounding import RoundingRepair
from pymoo.operators.sampling.rnd import IntegerRandomSampling
from pymoo.optimize import minimize
from pymoo.problems.single import G1

import robolaser
from robolaser.algorithms.seeding import seeded
from robolaser.benchmark.evaluator import RunLimits
from robolaser.benchmark.problem import BenchmarkProblem, ProblemSummary
from robolaser.benchmark.run import Task, run
from robolaser.benchmark.solvers import find


def test_a_noisy_problem_is_ranked_by_what_runs_returned_without_noise():
    result = robolaser.compare([Noisy()], ["random", "de"], seeds=3, budget=300)
    assert result.problems[0].noisy
    for one in result.runs:
        assert one.trace.final == pytest.approx(float((np.array(one.x) ** 2).sum()))
        assert one.trace.evaluations.tolist() == [300]
    assert "noisy: runs are ranked by" in str(result)


def test_without_the_exact_cost_it_is_evaluated_anew_and_never_the_luckiest_sample():
    result = robolaser.compare([Noisy(knows=False)], ["random"], seeds=3, budget=2000)
    truth = [float((np.array(one.x) ** 2).sum()) for one in result.runs]
    # The luckiest of 2000 samples lies some 700 below; the median of the noise, 100 ln 2 below.
    for one, cost in zip(result.runs, truth, strict=True):
        assert one.trace.final == pytest.approx(cost - 100 * np.log(2), abs=90)


def test_a_noisy_comparison_is_resumed(tmp_path):
    one = {"budget": 100, "output": tmp_path}
    robolaser.compare([Noisy()], ["random"], seeds=1, **one)
    assert len(robolaser.compare([Noisy()], ["random"], seeds=3, resume=True, **one).runs) == 3


class Recording(G1):
    """Remembers what it was asked."""

    def __init__(self):
        super().__init__()
        self.asked = []

    def _evaluate(self, x, out, *args, **kwargs):
        self.asked.append(x.copy())
        super()._evaluate(x, out, *args, **kwargs)


def test_isres_sees_constraints_and_searches_as_it_does_alone():
    compared, alone = Recording(), Recording()
    task = Task("p", "isres", 1, RunLimits(1000, 60.0), b"", b"", "")
    run(BenchmarkProblem(ProblemSummary("p", "", "own problem", 13, 1), compared), find("isres"), task)
    with seeded(1):
        minimize(alone, ISRES(), ("n_eval", 1000), seed=1)
    one, other = np.concatenate(compared.asked), np.concatenate(alone.asked)
    assert np.array_equal(one[:900], other[:900])


def test_inequalities_and_equalities_reach_an_algorithm_apart():
    seen = set()

    class Watched(GA):
        def _post_advance(self):
            super()._post_advance()
            seen.add((self.pop.get("G").shape[1], self.pop.get("H").shape[1]))

    task = Task("p", "ga", 1, RunLimits(100, 60.0), b"", b"", "")
    run(BenchmarkProblem(ProblemSummary("p", "", "own problem", 2, 1), Constrained()), find(Watched(pop_size=20)), task)
    assert seen == {(1, 1)}


def test_feasible_candidates_rank_before_infeasible_ones():
    result = robolaser.compare(["pymoo:g1"], ["random"], seeds=1, budget=300)
    (one,) = result.runs
    assert not len(one.trace.costs)
    assert one.violation > 0
    assert np.isinf(result.to_frame()["best"]).all()


class Crashing(Constrained):
    """Raises an error in one half."""

    def _evaluate(self, x, out, *args, **kwargs):
        if (x[:, 0] > 0.0).any():
            raise RuntimeError("diverged")
        super()._evaluate(x, out, *args, **kwargs)


def test_a_crash_under_constraints_may_cost_infinity():
    task = Task("p", "random", 1, RunLimits(100, 60.0, crash_costs_inf=True), b"", b"", "")
    one = run(BenchmarkProblem(ProblemSummary("p", "", "own problem", 2, 1), Crashing()), find("random"), task)
    assert (one.state, one.reason, one.evaluations) == ("done", "", 100)
    assert len(one.trace.costs)


def test_whole_numbers_stay_whole_or_the_algorithm_is_refused():
    mine = GA(pop_size=20, sampling=IntegerRandomSampling(), crossover=SBX(vtype=float, repair=RoundingRepair()),
              mutation=PM(vtype=float, repair=RoundingRepair()))  # fmt: skip
    result = robolaser.compare([Whole], {"de": "de", "random": "random", "mine": mine}, seeds=2, budget=400)
    assert set(result.refused) == {("Whole", "de")}
    assert {one.algorithm for one in result.runs} == {"random", "mine"}
    for one in result.runs:
        assert one.trace.final >= 0.75
        assert np.array_equal(one.x, np.round(one.x))


class Mixed(ElementwiseProblem):
    """Variables of three kinds."""

    def __init__(self):
        kinds = {"x": Real(bounds=(0, 1)), "k": Integer(bounds=(0, 5)), "on": Binary()}
        super().__init__(vars=kinds, n_obj=1)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = x["x"] + x["k"] + (not x["on"])


def test_mixed_variables_are_compared_by_algorithms_that_know_them():
    result = robolaser.compare(
        [Mixed], {"mixed": MixedVariableGA(pop_size=10), "random": "random", "ga": "ga"}, seeds=1, budget=100
    )
    assert set(result.refused) == {("Mixed", "ga")}
    best = next(one for one in result.runs if one.algorithm == "mixed")
    assert best.state == "done"
    assert set(best.x[0]) == {"x", "k", "on"}


def test_a_problem_that_changes_with_time_is_refused():
    with pytest.raises(robolaser.RobolaserError, match="changes with time"):
        robolaser.compare(["pymoo:df1"], ["NSGA2"], seeds=1, budget=100)
