"""Several objectives: what a run is measured by has no plateau, and comes from known fronts or from all runs'."""

import numpy as np
import pytest

import robolaser
from robolaser.benchmark.evaluator import ConvergenceTrace
from robolaser.benchmark.measures import attainment, measured
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.run import DONE, BenchmarkRun
from robolaser.benchmark.standings.ranking import standings


def run_of(name, *points):
    costs = np.array(points, float)
    trace = ConvergenceTrace(np.arange(1, len(costs) + 1), np.zeros(len(costs)), costs)
    return BenchmarkRun("p", name, 1, DONE, "", len(costs), 0.0, 0.0, trace)


def problem(front=None):
    return ProblemSummary("p", "", "several objectives", 2, 2, "", 10, front=front)


def test_far_from_the_front_nobody_succeeds_and_the_better_still_ranks_first():
    result = robolaser.compare(["pymoo:dtlz1"], ["NSGA2", "random"], seeds=5, budget=3000)
    order = standings(result, "several objectives").order
    assert [(place.algorithm, place.success.value) for place in order.places] == [("NSGA2", 0.0), ("random", 0.0)]
    assert order.pairs[0].significant


def test_whoever_comes_nearer_has_a_lower_cost_however_far_away():
    found, (far, farther) = measured(problem([[0, 1], [1, 0]]), [run_of("a", [50, 50]), run_of("b", [50, 60])])
    assert found.best == 0.0
    assert 0 < far.trace.final < farther.trace.final


def test_a_run_that_has_the_whole_front_has_no_distance_left():
    _, (run,) = measured(problem([[0, 1], [1, 0]]), [run_of("a", [3, 3], [0, 1], [1, 0])])
    assert run.trace.final == 0.0
    assert (np.diff(run.trace.costs) < 0).all()


def test_an_unknown_front_is_what_nothing_dominates_of_all_runs():
    runs = [run_of("a", [1, 4], [3, 3]), run_of("b", [4, 1], [9, 9])]
    found, (a, b) = measured(problem(), runs)
    assert found.found_by == "all runs together"
    # The front is (1, 4), (3, 3), (4, 1), each objective in units of 3; a lacks (4, 1) by 2/3 from (3, 3).
    assert a.trace.final == pytest.approx((0 + 0 + 2 / 3) / 3)
    assert b.trace.final == pytest.approx((1 + 1 / 3 + 0) / 3)


def test_half_of_all_runs_attain_the_median_surface_those_that_found_nothing_included():
    runs = [run_of("a", [1, 4], [3, 3]), run_of("a", [4, 1], [9, 9])]
    assert sorted(map(tuple, attainment(runs))) == [(1, 4), (3, 3), (4, 1)]
    none = BenchmarkRun("p", "a", 1, DONE, "", 0, 0.0, 0.0, ConvergenceTrace(*(np.empty(0),) * 3))
    assert [tuple(corner) for corner in attainment([*runs, none])] == [(4, 3)]
    assert not len(attainment([*runs, none, none, none]))


def test_infeasible_candidates_are_no_part_of_any_front():
    result = robolaser.compare(["pymoo:osy"], ["NSGA2"], seeds=2, budget=600)
    objectives = [run.trace.costs for run in result.made if len(run.trace.costs)]
    assert objectives
    assert (np.concatenate(objectives)[:, 0] < 0).all()  # where the box begins, at -1634, nothing is feasible
    assert np.concatenate(objectives)[:, 0].min() > -300


def test_algorithms_with_reference_directions_take_part_by_name():
    result = robolaser.compare(["pymoo:dtlz2"], ["NSGA3", "MOEAD", "RVEA"], seeds=1, budget=300)
    assert [run.state for run in result.runs] == [DONE] * 3
    assert result.know_budget == {"RVEA"}


def test_an_algorithm_that_needs_several_objectives_is_refused_where_there_is_one():
    needing = ("NSGA3", "MOEAD", "RVEA")
    result = robolaser.compare(["pymoo:sphere-2", "pymoo:dtlz2"], [*needing, "GA", "NSGA2"], seeds=1, budget=100)
    assert {(run.problem, run.algorithm) for run in result.runs if run.state == DONE} == {
        ("pymoo:sphere-2", "GA"),
        ("pymoo:sphere-2", "NSGA2"),
        ("pymoo:dtlz2", "NSGA2"),
        *(("pymoo:dtlz2", name) for name in needing),
    }
    for name in needing:
        why = f"{name} searches along reference directions, which need several objectives."
        assert result.refused["pymoo:sphere-2", name] == why
