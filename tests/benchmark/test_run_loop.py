"""Every run of a plan is made once, no more are handed out than are needed, and progress is reported truly."""

import time
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

import pytest
from made_up import made_up_run

from robolaser.benchmark.engines import Engine
from robolaser.benchmark.plan import RunPlan
from robolaser.benchmark.run_loop import AHEAD, compare, run_all
from robolaser.benchmark.single_run import BenchmarkRun, Task
from robolaser.benchmark.solvers.solver import Solver
from robolaser.benchmark.table import RunTable


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

    def share(self, payload: bytes) -> bytes:
        return payload

    def submit(self, task: Task, shared: bytes) -> Future:
        self.out += 1
        self.most = max(self.most, self.out)
        return self._thread.submit(self._make, task)

    def _make(self, task: Task) -> BenchmarkRun:
        time.sleep(0.002)
        self.out -= 1
        return made_up_run(task.algorithm, task.seed, problem=task.problem)

    def close(self) -> None:
        self._thread.shutdown()
        self.closed = True


@pytest.fixture
def plan():
    return RunPlan.of(["pymoo:sphere-2", "pymoo:ackley-2"], ["random", "rcga", "screening"], seeds=4, budget=100)


def test_every_contestant_meets_every_question_with_every_seed_once(plan):
    made = [run.key for run in run_all(plan, Recorded())]
    assert sorted(made) == sorted(
        (problem, algorithm, seed)
        for problem in ("pymoo:sphere-2", "pymoo:ackley-2")
        for algorithm in ("random", "rcga")  # screening has nothing to say there
        for seed in (1, 2, 3, 4)
    )


def test_who_fails_when_asked_whether_it_has_anything_to_say_has_nothing_to_say(plan):
    class Broken(Solver):
        name, title = "broken", "breaks"

        def search(self, evaluator, seed):
            pytest.fail("who has nothing to say was asked to search")

        def refuses(self, problem):
            raise RuntimeError("what?")

    refused = replace(plan, solvers=(Broken(),)).refused
    assert "RuntimeError: what?" in refused["pymoo:sphere-2", "broken"]


def test_all_runs_with_a_seed_go_out_before_those_with_the_next(plan):
    seeds = [task.seed for task in plan.tasks]
    assert seeds == sorted(seeds)


def test_runs_that_are_there_are_not_made_again(plan):
    there = {task.key: 1.0 for task in plan.tasks[:8]} | {("another plan's", "random", 1): 1.0}
    made = [run.key for run in run_all(plan, Recorded(), made=there)]
    assert sorted(made) == sorted(task.key for task in plan.tasks[8:])


def test_no_more_runs_are_handed_out_than_keep_the_workers_busy(plan):
    engine = Recorded(workers=3)
    list(run_all(plan, engine))
    assert engine.most == AHEAD * 3


def test_whoever_watches_is_told_what_is_done_what_runs_and_how_long_it_will_take(plan):
    reports = []
    each_s = made_up_run("random", 1).seconds
    there = {task.key: each_s for task in plan.tasks[:8]}
    runs = run_all(plan, Recorded(workers=2), made=there, progress=lambda words, share: reports.append((words, share)))
    next(runs)
    next(runs)
    words, share = reports[0]
    assert share == 9 / 16
    assert words.startswith(f"9/16 runs, 0:{7 * each_s / 2:02.0f} left, ")
    assert words.count("seed") == 2


def test_a_comparison_in_python_is_of_all_runs_and_leaves_no_engine_behind(plan):
    engine = Recorded()
    comparison = compare(plan, engine)
    assert len(comparison.runs) == comparison.wanted == 16
    assert engine.closed
    assert comparison.effort.engine == "recorded"


def test_a_question_whose_lowest_cost_theory_knows_is_measured_from_there(plan):
    comparison = compare(plan, Recorded())
    assert {problem.found_by for problem in comparison.problems} == {"theory"}
    assert {problem.best for problem in comparison.problems} == {0.0}


def test_the_best_known_calibration_is_the_lowest_of_our_own_search_and_all_runs():
    plan = RunPlan.of(["paper"], ["random"], seeds=4, budget=100)
    with RunTable() as table:
        table.begin(plan, engine="", workers=1)
        (before,) = table.result(plan).problems
    (after,) = compare(plan, Recorded()).problems  # made-up runs come below what is possible
    assert before.found_by == "robolaser's own search"
    assert after.found_by == "random"
    assert after.best < before.best
