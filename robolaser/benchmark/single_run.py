"""One solver on one problem with one seed: the task, as it is sent to another process, and the run that comes of it."""

import pickle
import time
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.engines.engine import Job
from robolaser.benchmark.evaluator import BudgetedEvaluator, BudgetExhausted, ConvergenceTrace
from robolaser.benchmark.problem import BenchmarkProblem, ProblemSpec
from robolaser.benchmark.solvers.solver import Solver
from robolaser.errors import RobolaserError

DONE, FAILED = "done", "failed"
WARM_UP = 300
"""Evaluations of an uncounted first run, in which a process imports and compiles what it needs."""

Key = tuple[str, str, int]
"""Problem, algorithm and seed of a run: what identifies it."""


@final
@dataclass(frozen=True, eq=False)
class BenchmarkRun:
    """The result of one run."""

    problem: str  # name of the problem
    algorithm: str  # name of the solver
    seed: int  # of the run
    state: str  # `DONE` if it ended by itself or used up its budget, else `FAILED`
    reason: str  # why it failed; empty if it did not
    evaluations: int  # candidates evaluated
    seconds: float  # wall time
    processor_s: float  # processor time
    trace: ConvergenceTrace  # every improvement; of failed runs as far as it is known
    violation: float = 0.0  # the lowest of the constraints'; 0 with a feasible candidate, or if nothing is known
    front: Array | None = None  # of several objectives: the values that nothing dominates, (n, m)
    x: Array | None = None  # the best candidate, (1, d), or those of the front, (n, d); none if they are not known

    @property
    def key(self) -> Key:
        """What identifies it."""
        return self.problem, self.algorithm, self.seed


def run(problem: BenchmarkProblem, solver: Solver, *, seed: int, budget: int, time_limit_s: float) -> BenchmarkRun:
    """Run a solver until it stops, its budget or its time is used up, or it fails."""
    evaluator = BudgetedEvaluator(problem, budget=budget, time_limit_s=time_limit_s)
    began, reason = time.process_time(), ""
    try:
        with np.errstate(all="ignore"):
            solver.search(evaluator, seed)
    except BudgetExhausted:
        pass
    except MemoryError:
        reason = "it needed more memory than it may use"
    except SystemExit as stopped:
        reason = f"it called sys.exit({stopped.code!r})"
    except RobolaserError as error:
        reason = str(error)
    except Exception as error:
        reason = f"{type(error).__name__}: {error}".strip().removesuffix(":")
    if evaluator.out_of_time:
        reason = f"not done within {time_limit_s:g} s"
    return BenchmarkRun(
        problem=problem.name,
        algorithm=solver.name,
        seed=seed,
        state=FAILED if reason else DONE,
        reason=reason,
        evaluations=evaluator.evaluations,
        seconds=evaluator.seconds(),
        processor_s=time.process_time() - began,
        trace=evaluator.trace(),
        violation=evaluator.violation if np.isfinite(evaluator.violation) else 0.0,
        front=None if evaluator.front is None else evaluator.front.points,
        x=evaluator.x if evaluator.front is None else evaluator.front.x,
    )


@final
@dataclass(frozen=True)
class Task(Job):
    """Which solver is to run on which problem, with which seed and limits."""

    problem: str
    algorithm: str  # as the user named it
    seed: int
    budget: int  # evaluations it may spend
    time_limit_s: float
    memory_limit_b: int  # beyond what its process needs anyway
    solver: bytes = b""  # pickled, where no other process could find it by its name

    @property
    def key(self) -> Key:
        """What identifies its run."""
        return self.problem, self.algorithm, self.seed

    @property
    def kind(self) -> str:
        """Runs of one solver warm up alike."""
        return self.algorithm

    def prepared(self, payload: ProblemSpec) -> BenchmarkProblem:
        """The problem, built."""
        return payload.problem()

    def warm_up(self, prepared: BenchmarkProblem) -> None:
        """An uncounted first run."""
        self._run(prepared, min(WARM_UP, self.budget))

    def done(self, prepared: BenchmarkProblem) -> BenchmarkRun:
        """The run."""
        return self._run(prepared, self.budget)

    def failed(self, reason: str, *, seconds: float = 0.0) -> BenchmarkRun:
        """A failed run of which only the reason and the time are known."""
        nothing = ConvergenceTrace(np.empty(0, np.int64), np.empty(0), np.empty(0))
        return BenchmarkRun(*self.key, FAILED, reason, 0, seconds, 0.0, nothing)

    def _run(self, problem: BenchmarkProblem, budget: int) -> BenchmarkRun:
        from robolaser.benchmark.solvers import find  # noqa: PLC0415 - with it come pymoo and SciPy

        solver = pickle.loads(self.solver) if self.solver else find(self.algorithm)
        made = run(problem, solver, seed=self.seed, budget=budget, time_limit_s=self.time_limit_s)
        return replace(made, problem=self.problem, algorithm=self.algorithm)
