"""One contestant on one question with one seed."""

import time
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.benchmark.convergence import Course
from robolaser.benchmark.evaluator import Over, Watch
from robolaser.benchmark.problem import Question
from robolaser.benchmark.solvers.solver import Contestant
from robolaser.errors import RobolaserError

DONE, FAILED = "done", "failed"
WARM_UP = 300
"""Evaluations of a run that nobody counts: a process compiles and imports what it needs before the clock runs."""


@final
@dataclass(frozen=True, eq=False)
class Run:
    """What came of one run.

    Attributes:
        problem: Name of the question.
        algorithm: Name of the contestant.
        seed: Of the run.
        state: `DONE` when it ended by itself or used up its budget, else `FAILED`.
        reason: Why it failed; empty if it did not.
        evaluations: Candidates evaluated.
        seconds: Wall time.
        processor_s: Processor time.
        course: Every improvement, of failed runs as far as it is known.
    """

    problem: str
    algorithm: str
    seed: int
    state: str
    reason: str
    evaluations: int
    seconds: float
    processor_s: float
    course: Course


def run(question: Question, contestant: Contestant, *, seed: int, budget: int, time_limit_s: float) -> Run:
    """Let a contestant search until it stops, its budget is used up, its time is up or it fails."""
    watch = Watch(question, budget=budget, time_limit_s=time_limit_s)
    began, reason = time.process_time(), ""
    try:
        with np.errstate(all="ignore"):
            contestant.search(watch, seed)
    except Over:
        pass
    except MemoryError:
        reason = "it wanted more memory than it may have"
    except SystemExit as stopped:
        reason = f"it called sys.exit({stopped.code!r})"
    except RobolaserError as error:
        reason = str(error)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".strip().removesuffix(":")
    if watch.out_of_time:
        reason = f"not done within {time_limit_s:g} s"
    return Run(
        problem=question.name,
        algorithm=contestant.name,
        seed=seed,
        state=FAILED if reason else DONE,
        reason=reason,
        evaluations=watch.evaluations,
        seconds=watch.seconds(),
        processor_s=time.process_time() - began,
        course=watch.course(),
    )
