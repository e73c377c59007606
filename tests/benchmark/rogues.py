"""Solvers that behave and such that do not, and a problem for them."""

import ctypes
import os
import random
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import numpy as np

from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import TEST_FUNCTION, BenchmarkProblem, ProblemSpec


def bowl(*, broken: bool = False, title: str = "") -> BenchmarkProblem:
    if broken:
        raise ValueError("no such bowl")
    ones = np.ones(3)
    return BenchmarkProblem(
        "bowl", title, TEST_FUNCTION, ("x", "y", "z"), -ones, ones, lambda x: (x**2).sum(axis=1), "", 1.0, lowest=0.0
    )


def spec(*, broken: bool = False, title: str = "") -> ProblemSpec:
    return ProblemSpec("bowl", partial(bowl, broken=broken, title=title))


def walks(evaluator: BudgetedEvaluator, seed: int) -> None:
    rng = np.random.default_rng(seed)
    while True:
        evaluator.cost(evaluator.problem.sample_uniform(rng, 10) * random.random() * np.random.random())  # noqa: NPY002 - as some algorithms do


def dawdles(evaluator: BudgetedEvaluator, seed: int) -> None:
    time.sleep(0.1)
    walks(evaluator, seed)


def meets(evaluator: BudgetedEvaluator, seed: int) -> None:
    place = Path(evaluator.problem.title)
    (place / str(os.getpid())).touch()
    while len(list(place.iterdir())) < 3:
        time.sleep(0.01)
    walks(evaluator, seed)


def stumbles(evaluator: BudgetedEvaluator, seed: int) -> None:
    evaluator.cost(np.zeros((1, 3)))
    raise ZeroDivisionError("no ground")


def dreams(evaluator: BudgetedEvaluator, seed: int) -> None:
    evaluator.cost(np.full((1, 3), np.nan))


def _amid() -> None:
    if "ROGUES_AMID" in os.environ:
        Path(os.environ["ROGUES_AMID"]).touch()


def circles(evaluator: BudgetedEvaluator, seed: int) -> None:
    _amid()
    while True:
        pass


def circles_later(evaluator: BudgetedEvaluator, seed: int) -> None:
    evaluator.cost(np.zeros((300, 3)))
    circles(evaluator, seed)


def freezes(evaluator: BudgetedEvaluator, seed: int) -> None:
    _amid()
    ctypes.PyDLL(None).pause()  # without letting go of the interpreter


def hoards(evaluator: BudgetedEvaluator, seed: int) -> None:
    hoard = []
    while True:
        hoard.append(np.ones(1 << 20))


kept = []


def keeps(evaluator: BudgetedEvaluator, seed: int) -> None:
    while True:
        kept.append(np.ones(1 << 20))


def quits(evaluator: BudgetedEvaluator, seed: int) -> None:
    os._exit(3)


def leaves(evaluator: BudgetedEvaluator, seed: int) -> None:
    sys.exit(3)


def closes(evaluator: BudgetedEvaluator, seed: int) -> None:
    os.closerange(3, 100)
    circles(evaluator, seed)


def chatters(evaluator: BudgetedEvaluator, seed: int) -> None:
    for _ in range(2000):
        print("bla" * 100)
        os.write(1, b"bla" * 100)
        os.write(2, b"bla" * 100)
    subprocess.run(["echo", "bla"], check=True)
    walks(evaluator, seed)


def dies_once(evaluator: BudgetedEvaluator, seed: int) -> None:
    try:
        with open(os.environ["ROGUES_GRAVE"], "x"):
            pass
    except FileExistsError:
        walks(evaluator, seed)
    os.kill(os.getpid(), signal.SIGKILL)


def waits(evaluator: BudgetedEvaluator, seed: int) -> None:
    evaluator.cost(np.zeros((1, 3)))
    _amid()
    time.sleep(1000)
