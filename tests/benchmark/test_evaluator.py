"""A budgeted evaluator counts right, records every improvement and ends the run in time."""

import itertools

import numpy as np
import pytest
from pymoo.core.problem import Problem

from robolaser.benchmark.evaluator import BudgetedEvaluator, BudgetExhausted, RunLimits
from robolaser.benchmark.problem import BenchmarkProblem, ProblemSummary
from robolaser.benchmark.run import DONE, FAILED, Task, run
from robolaser.benchmark.solvers.solver import Solver
from robolaser.errors import BenchmarkError


class Bowl(Problem):
    """Squares of three variables, or what else a test wants."""

    def __init__(self, cost=lambda x: (x**2).sum(axis=1)):
        super().__init__(n_var=3, n_obj=1, xl=-1.0, xu=1.0)
        self.names, self.cost = ("a", "b", "c"), cost

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = self.cost(x)


def bowl(**changed) -> BenchmarkProblem:
    return BenchmarkProblem(
        ProblemSummary("bowl", "a bowl", "test function", 3, 1), Bowl(**changed), residuals=lambda x: x
    )


def evaluator(*, budget: int = 100, time_limit_s: float = 60.0, **changed) -> BudgetedEvaluator:
    return BudgetedEvaluator(bowl(**changed), RunLimits(budget, time_limit_s))


def ran(search, *, budget: int = 100, time_limit_s: float = 60.0, **changed):
    limits = RunLimits(budget, time_limit_s)
    return run(bowl(**changed), Solver("asking", "asks", search), Task("bowl", "asking", 1, limits, b"", b"", ""))


def test_every_improvement_within_a_batch_is_recorded_at_its_own_evaluation():
    budgeted = evaluator()
    budgeted.cost(np.array([[0.5, 0, 0], [0.9, 0, 0], [0.1, 0, 0], [0.2, 0, 0]]))
    budgeted.cost(np.array([[0.05, 0, 0]]))
    assert budgeted.trace().evaluations.tolist() == [1, 3, 5]
    np.testing.assert_allclose(budgeted.trace().costs, [0.25, 0.01, 0.0025])


def test_what_lies_beyond_the_budget_does_not_count():
    budgeted = evaluator(budget=2)
    with pytest.raises(BudgetExhausted):
        budgeted.cost(np.array([[0.5, 0, 0], [0.4, 0, 0], [0.0, 0, 0]]))
    assert (budgeted.evaluations, budgeted.best) == (2, pytest.approx(0.16))


def test_residuals_are_counted_as_costs_are():
    budgeted = evaluator()
    budgeted.residuals(np.array([[0.5, 0, 0], [0.4, 0.1, 0]]))
    assert budgeted.evaluations == 2
    assert budgeted.best == pytest.approx(0.17)


def test_a_candidate_outside_the_bounds_costs_infinitely_much():
    budgeted = evaluator()
    assert np.isinf(budgeted.cost(np.array([[1.0000001, 0, 0]]))).all()
    assert budgeted.evaluations == 1
    assert np.isinf(budgeted.best)


def test_a_problem_is_never_asked_about_no_candidates():
    budgeted = evaluator(cost=lambda x: x.sum(axis=1) - x.max())  # NumPy has no largest of nothing
    assert np.isinf(budgeted.cost(np.array([[2.0, 0, 0]]))).all()


def test_a_pole_costs_infinitely_much_whatever_the_problem_returns():
    budgeted = evaluator(cost=lambda x: np.where(x[:, 0] > 0, np.nan, 1.0))
    assert budgeted.cost(np.array([[0.5, 0, 0], [-0.5, 0, 0]])).tolist() == [np.inf, 1.0]


@pytest.mark.parametrize("wrong", [np.zeros(3), np.zeros((2, 4)), np.zeros((1, 1, 3))])
def test_an_array_of_another_shape_is_refused(wrong):
    with pytest.raises(BenchmarkError, match=r"\(candidates, 3\)"):
        evaluator().cost(wrong)


def test_a_candidate_that_is_not_a_number_is_refused_by_the_name_of_its_variable():
    with pytest.raises(BenchmarkError, match="whose b is not a number"):
        evaluator().cost(np.array([[0, 0, 0], [0, np.nan, 0]]))


def test_what_a_solver_evaluated_by_itself_is_counted():
    budgeted = evaluator(budget=10)
    budgeted.record(4, 0.3)
    budgeted.record(4, 0.4)
    with pytest.raises(BudgetExhausted):
        budgeted.record(4, 0.1)
    assert budgeted.trace().costs.tolist() == [0.3]
    assert budgeted.evaluations == 10


def test_a_target_is_first_reached_where_the_trace_first_lies_at_or_below_it():
    budgeted = evaluator()
    for a in (0.9, 0.5, 0.2):
        budgeted.cost(np.array([[a, 0, 0]]))
    evaluations, seconds = budgeted.trace().first_hits(np.array([1.0, 0.25, 0.24, 0.01]))
    assert evaluations.tolist() == [1, 2, 3, np.inf]
    assert np.isinf(seconds[3])


def test_a_run_that_stops_by_itself_is_done():
    one = ran(lambda budgeted, seed: budgeted.cost(np.zeros((3, 3))))
    assert (one.state, one.reason, one.evaluations) == (DONE, "", 3)


def test_a_run_that_raises_has_failed_and_keeps_what_it_found():
    def search(budgeted, seed):
        budgeted.cost(np.full((1, 3), 0.1))
        raise ValueError("no such luck")

    one = ran(search)
    assert (one.state, one.reason) == (FAILED, "ValueError: no such luck")
    assert one.trace.final == pytest.approx(0.03)


def test_the_end_comes_whenever_the_budget_is_used_up_however_it_is_asked_for():
    for size in (1, 3, 7, 100, 1000):

        def search(budgeted, seed, size=size):
            for _ in itertools.count():
                budgeted.cost(np.zeros((size, 3)))

        assert ran(search, budget=100).evaluations == 100
