"""A contest is held: every run once, no more handed out than is needed, and whoever watches is told the truth."""

import time
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

import pytest
from made_up import made_up_run

from robolaser.benchmark.engines import Engine, Payload, Task
from robolaser.benchmark.plan import Contest, key
from robolaser.benchmark.run_loop import AHEAD, compare, held
from robolaser.benchmark.single_run import Run
from robolaser.benchmark.solvers.solver import Contestant


class Recorded(Engine):
    """Gives made-up runs one at a time, and notes how many are out."""

    label = "recorded"

    def __init__(self, workers: int = 2) -> None:
        self._workers = workers
        self._thread = ThreadPoolExecutor(1)
        self.out, self.most = 0, 0
        self.closed = False

    @property
    def workers(self) -> int:
        return self._workers

    def share(self, payload: bytes) -> Payload:
        return Payload("", payload)

    def submit(self, task: Task, payload: Payload) -> Future:
        self.out += 1
        self.most = max(self.most, self.out)
        return self._thread.submit(self._make, task)

    def _make(self, task: Task) -> Run:
        time.sleep(0.002)
        self.out -= 1
        return made_up_run(task.algorithm, task.seed, problem=task.problem)

    def close(self) -> None:
        self._thread.shutdown()
        self.closed = True


@pytest.fixture
def contest():
    return Contest.of(["pymoo:sphere-2", "pymoo:ackley-2"], ["random", "rcga", "screening"], seeds=4, budget=100)


def test_every_contestant_meets_every_question_with_every_seed_once(contest):
    made = [key(run) for run in held(contest, Recorded(), tell=lambda moment: None)]
    assert sorted(made) == sorted(
        (problem, algorithm, seed)
        for problem in ("pymoo:sphere-2", "pymoo:ackley-2")
        for algorithm in ("random", "rcga")  # screening has nothing to say there
        for seed in (1, 2, 3, 4)
    )


def test_who_fails_when_asked_whether_it_has_anything_to_say_has_nothing_to_say(contest):
    class Broken(Contestant):
        name, title = "broken", "breaks"

        def search(self, watch, seed):
            pytest.fail("who has nothing to say was asked to search")

        def refuses(self, question):
            raise RuntimeError("what?")

    refused = replace(contest, contestants=(Broken(),)).refused
    assert "RuntimeError: what?" in refused["pymoo:sphere-2", "broken"]


def test_all_runs_with_a_seed_go_out_before_those_with_the_next(contest):
    seeds = [task.seed for task in contest.tasks]
    assert seeds == sorted(seeds)


def test_runs_that_are_there_are_not_made_again(contest):
    there = [made_up_run(task.algorithm, task.seed, problem=task.problem) for task in contest.tasks[:8]]
    made = [key(run) for run in held(contest, Recorded(), made=there, tell=lambda moment: None)]
    assert sorted(made) == sorted(key(task) for task in contest.tasks[8:])


def test_no_more_runs_are_handed_out_than_keep_the_workers_busy(contest):
    engine = Recorded(workers=3)
    list(held(contest, engine, tell=lambda moment: None))
    assert engine.most == AHEAD * 3


def test_whoever_watches_is_told_what_is_done_what_runs_and_how_long_it_will_take(contest):
    moments = []
    there = [made_up_run(task.algorithm, task.seed, problem=task.problem) for task in contest.tasks[:8]]
    runs = held(contest, Recorded(workers=2), made=there, tell=moments.append)
    next(runs)
    next(runs)
    first = moments[0]
    assert (first.done, first.wanted, len(first.running)) == (9, 16, 2)
    each_s = made_up_run("random", 1).seconds
    assert first.left_s == pytest.approx(7 * each_s / 2)


def test_a_comparison_in_python_is_of_all_runs_and_leaves_no_engine_behind(contest):
    engine = Recorded()
    comparison = compare(contest, engine)
    assert len(comparison.runs) == comparison.wanted == 16
    assert engine.closed
    assert comparison.effort.engine == "recorded"


def test_a_question_whose_lowest_cost_theory_knows_is_measured_from_there(contest):
    comparison = compare(contest, Recorded())
    assert {problem.found_by for problem in comparison.problems} == {"theory"}
    assert {problem.best for problem in comparison.problems} == {0.0}


def test_the_best_known_calibration_is_the_lowest_of_our_own_search_and_all_runs():
    contest = Contest.of(["paper"], ["random"], seeds=4, budget=100)
    (before,) = contest.so_far((), compare(contest, Recorded()).effort).problems
    (after,) = compare(contest, Recorded()).problems  # made-up runs come below what is possible
    assert before.found_by == "robolaser's own search"
    assert after.found_by == "random"
    assert after.best < before.best
