"""Whoever stands beside a run counts right, notes every improvement and ends it in time."""

import itertools
import time

import numpy as np
import pytest

from robolaser.benchmark.evaluator import Over, Watch
from robolaser.benchmark.problem import TEST_FUNCTION, Question
from robolaser.benchmark.single_run import DONE, FAILED, run
from robolaser.benchmark.solvers.solver import Contestant
from robolaser.errors import CandidateNotANumber, CandidateShape


def bowl(**changed) -> Question:
    asked = {
        "name": "bowl",
        "title": "a bowl",
        "family": TEST_FUNCTION,
        "variables": ("a", "b", "c"),
        "lower": np.array([-1.0, -1.0, -1.0]),
        "upper": np.array([1.0, 1.0, 1.0]),
        "cost": lambda x: (x**2).sum(axis=1),
        "unit": "",
        "scale": 1.0,
        "residuals": lambda x: x,
    }
    return Question(**(asked | changed))


def watch(*, budget: int = 100, time_limit_s: float = 60.0, **changed) -> Watch:
    return Watch(bowl(**changed), budget=budget, time_limit_s=time_limit_s)


class Asking(Contestant):
    """Does what a test wants."""

    name, title = "asking", "asks"

    def __init__(self, search) -> None:
        self._search = search

    def search(self, watch: Watch, seed: int) -> None:
        self._search(watch, seed)


def ran(search, *, budget: int = 100, time_limit_s: float = 60.0, **changed):
    return run(bowl(**changed), Asking(search), seed=1, budget=budget, time_limit_s=time_limit_s)


def test_every_improvement_within_a_batch_is_noted_at_its_own_evaluation():
    beside = watch()
    beside.cost(np.array([[0.5, 0, 0], [0.9, 0, 0], [0.1, 0, 0], [0.2, 0, 0]]))
    beside.cost(np.array([[0.05, 0, 0]]))
    assert beside.course().evaluations.tolist() == [1, 3, 5]
    np.testing.assert_allclose(beside.course().costs, [0.25, 0.01, 0.0025])


def test_what_lies_beyond_the_budget_does_not_count():
    beside = watch(budget=2)
    with pytest.raises(Over):
        beside.cost(np.array([[0.5, 0, 0], [0.4, 0, 0], [0.0, 0, 0]]))
    assert (beside.evaluations, beside.best) == (2, pytest.approx(0.16))


def test_residuals_are_paid_for_as_costs_are():
    beside = watch()
    beside.residuals(np.array([[0.5, 0, 0], [0.4, 0.1, 0]]))
    assert beside.evaluations == 2
    assert beside.best == pytest.approx(0.17)


def test_a_candidate_outside_the_bounds_costs_infinitely_much():
    beside = watch()
    assert np.isinf(beside.cost(np.array([[1.0000001, 0, 0]]))).all()
    assert beside.evaluations == 1
    assert np.isinf(beside.best)


def test_a_pole_costs_infinitely_much_whatever_the_question_says_of_it():
    beside = watch(cost=lambda x: np.where(x[:, 0] > 0, np.nan, 1.0))
    assert beside.cost(np.array([[0.5, 0, 0], [-0.5, 0, 0]])).tolist() == [np.inf, 1.0]


@pytest.mark.parametrize("wrong", [np.zeros(3), np.zeros((2, 4)), np.zeros((1, 1, 3))])
def test_what_is_no_array_of_candidates_is_refused(wrong):
    with pytest.raises(CandidateShape, match=r"\(candidates, 3\)"):
        watch().cost(wrong)


def test_a_candidate_that_is_not_a_number_is_refused_by_the_name_of_its_variable():
    with pytest.raises(CandidateNotANumber, match="whose b is not a number"):
        watch().cost(np.array([[0, 0, 0], [0, np.nan, 0]]))


def test_what_a_contestant_evaluated_by_itself_is_paid_for():
    beside = watch(budget=10)
    beside.saw(4, 0.3)
    beside.saw(4, 0.4)
    with pytest.raises(Over):
        beside.saw(4, 0.1)
    assert beside.course().costs.tolist() == [0.3]
    assert beside.evaluations == 10


def test_costs_of_a_course_fall_and_evaluations_rise():
    rng = np.random.default_rng(1)
    beside = watch(budget=1000)
    for _ in range(100):
        beside.cost(rng.uniform(-1, 1, (7, 3)))
    course = beside.course()
    assert (np.diff(course.costs) < 0).all()
    assert (np.diff(course.evaluations) > 0).all()
    assert (np.diff(course.seconds) >= 0).all()


def test_a_target_is_first_reached_where_the_course_first_lies_at_or_below_it():
    beside = watch()
    for a in (0.9, 0.5, 0.2):
        beside.cost(np.array([[a, 0, 0]]))
    evaluations, seconds = beside.course().first(np.array([1.0, 0.25, 0.24, 0.01]))
    assert evaluations.tolist() == [1, 2, 3, np.inf]
    assert np.isinf(seconds[3])
    assert beside.course().after(np.array([0, 1, 2, 99])) == pytest.approx([np.inf, 0.81, 0.25, 0.04])


def test_a_course_without_candidates_reaches_nothing():
    assert np.isinf(watch().course().first(np.array([1.0]))[0]).all()
    assert np.isinf(watch().course().final)


def test_a_run_that_stops_by_itself_is_done():
    one = ran(lambda beside, seed: beside.cost(np.zeros((3, 3))))
    assert (one.state, one.reason, one.evaluations) == (DONE, "", 3)


def test_a_run_that_raises_has_failed_and_keeps_what_it_found():
    def search(beside, seed):
        beside.cost(np.full((1, 3), 0.1))
        raise ValueError("no such luck")

    one = ran(search)
    assert (one.state, one.reason) == (FAILED, "ValueError: no such luck")
    assert one.course.final == pytest.approx(0.03)


def test_an_error_without_words_is_named():
    def search(beside, seed):
        raise ZeroDivisionError

    assert ran(search).reason == "ZeroDivisionError"


def test_a_contestant_that_survives_its_own_errors_does_not_survive_the_end():
    def search(beside, seed):
        for _ in range(1000):
            try:
                beside.cost(np.zeros((1, 3)))
            except Exception:
                continue

    assert ran(search, budget=10).evaluations == 10


def test_a_run_that_goes_on_for_too_long_has_failed_by_the_clock():
    def search(beside, seed):
        while True:
            time.sleep(0.01)
            beside.cost(np.full((1, 3), 0.1))

    one = ran(search, time_limit_s=0.05, budget=10**9)
    assert (one.state, one.reason) == (FAILED, "not done within 0.05 s")
    assert one.course.final == pytest.approx(0.03)


def test_the_end_comes_whenever_the_budget_is_used_up_however_it_is_asked_for():
    for size in (1, 3, 7, 100, 1000):

        def search(beside, seed, size=size):
            for _ in itertools.count():
                beside.cost(np.zeros((size, 3)))

        assert ran(search, budget=100).evaluations == 100
