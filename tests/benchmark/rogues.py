"""Contestants that behave and such that do not, and a question for them."""

import ctypes
import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from robolaser.benchmark.evaluator import Watch
from robolaser.benchmark.problem import TEST_FUNCTION, Question
from robolaser.benchmark.problem_specs import Source


@final
@dataclass(frozen=True)
class Bowl(Source):
    name: str = "bowl"
    broken: bool = False

    def question(self) -> Question:
        if self.broken:
            raise ValueError("no such bowl")
        ones = np.ones(3)
        return Question(
            self.name,
            "",
            TEST_FUNCTION,
            ("x", "y", "z"),
            -ones,
            ones,
            lambda x: (x**2).sum(axis=1),
            "",
            1.0,
            lowest=0.0,
        )


def walks(watch: Watch, seed: int) -> None:
    rng = np.random.default_rng(seed)
    while True:
        watch.cost(watch.question.anywhere(rng, 10) * random.random() * np.random.random())  # noqa: NPY002 - as some algorithms do


def dawdles(watch: Watch, seed: int) -> None:
    time.sleep(0.1)
    walks(watch, seed)


def stumbles(watch: Watch, seed: int) -> None:
    watch.cost(np.zeros((1, 3)))
    raise ZeroDivisionError("no ground")


def dreams(watch: Watch, seed: int) -> None:
    watch.cost(np.full((1, 3), np.nan))


def _amid() -> None:
    if "ROGUES_AMID" in os.environ:
        Path(os.environ["ROGUES_AMID"]).touch()


def circles(watch: Watch, seed: int) -> None:
    _amid()
    while True:
        pass


def circles_later(watch: Watch, seed: int) -> None:
    watch.cost(np.zeros((300, 3)))
    circles(watch, seed)


def freezes(watch: Watch, seed: int) -> None:
    _amid()
    ctypes.PyDLL(None).pause()  # without letting go of the interpreter


def hoards(watch: Watch, seed: int) -> None:
    hoard = []
    while True:
        hoard.append(np.ones(1 << 20))


kept = []


def keeps(watch: Watch, seed: int) -> None:
    while True:
        kept.append(np.ones(1 << 20))


def quits(watch: Watch, seed: int) -> None:
    os._exit(3)


def leaves(watch: Watch, seed: int) -> None:
    sys.exit(3)


def closes(watch: Watch, seed: int) -> None:
    os.closerange(3, 100)
    circles(watch, seed)


def chatters(watch: Watch, seed: int) -> None:
    for _ in range(2000):
        print("bla" * 100)
        os.write(1, b"bla" * 100)
        os.write(2, b"bla" * 100)
    subprocess.run(["echo", "bla"], check=True)
    walks(watch, seed)


def dies_once(watch: Watch, seed: int) -> None:
    try:
        with open(os.environ["ROGUES_GRAVE"], "x"):
            pass
    except FileExistsError:
        walks(watch, seed)
    os.kill(os.getpid(), signal.SIGKILL)


def waits(watch: Watch, seed: int) -> None:
    watch.cost(np.zeros((1, 3)))
    _amid()
    time.sleep(1000)
