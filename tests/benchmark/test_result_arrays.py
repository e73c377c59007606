"""Runs become arrays without a number getting lost or into the wrong place."""

from dataclasses import replace

import numpy as np
import pytest
from made_up import BUDGET, made_up_comparison, made_up_run

from robolaser.benchmark.measures import ABSOLUTE, RELATIVE, TOLERANCE, tolerances


@pytest.fixture
def comparison():
    return made_up_comparison({"de": 1.0, "rcga": 2.0}, seeds=4)


def test_each_run_is_at_its_own_place(comparison):
    arrays = comparison.arrays("calibration")
    for run in comparison.runs:
        at = arrays.problems.index(run.problem), arrays.algorithms.index(run.algorithm), arrays.seeds.index(run.seed)
        np.testing.assert_array_equal(arrays.evaluations[at], run.trace.first_hits(RELATIVE)[0])
        assert arrays.total_s[at] == run.seconds
        assert arrays.final[at] == run.trace.final


def test_what_was_not_run_is_not_a_number(comparison):
    arrays = replace(comparison, runs=comparison.runs[1:]).arrays("calibration")
    assert (~arrays.there).sum() == 1
    assert np.isnan(arrays.evaluations[~arrays.there]).all()
    assert np.isnan(arrays.final[~arrays.there]).all()


def test_a_failed_run_counts_as_if_it_had_spent_the_budget(comparison):
    failed = replace(made_up_run("de", 1, reason="gave up"), evaluations=17)
    arrays = replace(comparison, runs=(failed,)).arrays("calibration")
    assert arrays.failed.sum() == 1
    assert arrays.total_evaluations[arrays.failed] == BUDGET


def test_a_run_that_found_nothing_ends_infinitely_far_off_even_where_nobody_found_anything(comparison):
    run = made_up_run("de", 1)
    nothing = replace(run, trace=type(run.trace)(np.array([], int), np.array([]), np.array([])))
    problems = tuple(replace(problem, best=np.inf) for problem in comparison.problems)
    arrays = replace(comparison, problems=problems, runs=(nothing,)).arrays("calibration")
    assert np.isinf(arrays.final[arrays.there]).all()
    assert np.isinf(arrays.evaluations[arrays.there]).all()


def test_targets_are_measured_from_the_best_known_cost_in_units_of_it(comparison):
    problems = tuple(replace(problem, best=1e-3, floor=1e-12) for problem in comparison.problems)
    arrays = replace(comparison, problems=problems).arrays("calibration")
    at = comparison.runs[0].trace.first_hits(np.array([1e-3 * (1 + TOLERANCE)]))[0][0]
    assert arrays.evaluations[0, 0, 0, arrays.headline] == at


def test_a_target_that_is_asked_for_is_among_the_targets():
    asked = tolerances("own problem", 3e-5)
    assert len(ABSOLUTE) == 51
    assert len(asked) == 52
    assert 3e-5 in asked
    assert (np.diff(asked) < 0).all()


def test_families_are_counted_apart(comparison):
    ackley = replace(comparison.problems[0], name="pymoo:ackley-10", family="test function")
    both = replace(comparison, problems=(*comparison.problems, ackley))
    assert both.families == ("calibration", "test function")
    assert both.arrays("test function").problems == ("pymoo:ackley-10",)
    assert both.arrays("calibration").problems == ("paper", "reduced:paper")


def test_who_has_nothing_to_say_on_a_family_is_not_counted_in_it(comparison):
    asked = replace(comparison, refused={(problem.name, "de"): "no" for problem in comparison.problems})
    assert asked.arrays("calibration").algorithms == ("rcga",)
    assert asked.wanted == comparison.wanted / 2
