"""One solver on one problem with one seed: the task, which is sent to another process, and its run."""

import json
import pickle
import time
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.benchmark.evaluator import BudgetedEvaluator, BudgetExhausted, ConvergenceTrace, RunLimits
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.solver import Solver
from robolaser.errors import BenchmarkError, RobolaserError

DONE, FAILED = "done", "failed"
PROBE_SEED = 1
REPEATS = 25  # uncounted evaluations whose median is the result of a run on a noisy problem without `exact`
PROBE_DIGITS = 9  # digits of the costs that identify a problem: another machine may round differently

RunKey = tuple[str, str, int]  # problem, algorithm and seed of a run, which identify it


@final
@dataclass(frozen=True, eq=False)
class BenchmarkRun:
    """The result of one run."""

    problem: str
    algorithm: str
    seed: int
    state: str  # `DONE` if it ended by itself, used up its budget or its time, else `FAILED`
    reason: str  # of its failure or early end; empty otherwise
    evaluations: int  # candidates evaluated
    seconds: float  # wall time
    processor_s: float  # processor time
    trace: ConvergenceTrace  # every improvement
    violation: float = 0.0  # lowest violation of constraints; 0 with a feasible candidate, or if unknown
    x: Any = None  # the best candidates, lists of numbers or dictionaries

    @property
    def key(self) -> RunKey:
        """Problem, algorithm and seed, which identify it."""
        return self.problem, self.algorithm, self.seed


@final
@dataclass(frozen=True)
class Task:
    """A run to be made: solver, problem, seed and limits."""

    problem: str
    algorithm: str
    seed: int
    limits: RunLimits
    spec: bytes  # the problem's, pickled
    solver: bytes  # pickled
    fingerprint: str  # of the problem where it was planned; empty: it is not checked
    spill: str = ""  # file for its improvements, in case its process is killed; empty: none

    @property
    def key(self) -> RunKey:
        """Key of its run."""
        return self.problem, self.algorithm, self.seed

    def lost(self, reason: str) -> BenchmarkRun:
        """A lost run by its reason and its spill file; failed, unless its whole budget was used up."""
        spilt = Path(self.spill).read_text() if self.spill and Path(self.spill).exists() else ""
        steps = [json.loads(line) for line in spilt.split("\n")[:-1]]  # the last may be half a line
        trace = ConvergenceTrace.of(filter(None, steps))
        evaluations, seconds = int(trace.evaluations.max(initial=0)), float(trace.seconds.max(initial=0.0))
        if [] in steps:
            return BenchmarkRun(*self.key, DONE, "", self.limits.budget, seconds, 0.0, trace)
        return BenchmarkRun(*self.key, FAILED, reason, evaluations, seconds, 0.0, trace)


def done(task: Task) -> BenchmarkRun:
    """Make the run of a task in this process."""
    try:
        _check(task.spec, task.fingerprint)
        problem, solver = pickle.loads(task.spec).made_for(task.seed), pickle.loads(task.solver)
    except Exception as error:
        return task.lost(_reason(error))
    return run(problem, solver, task)


@lru_cache(maxsize=64)
def _check(pickled: bytes, expected: str) -> None:
    """Raise if a problem differs from that where it was planned."""
    if expected and fingerprint(pickle.loads(pickled).made_for(1)) != expected:
        raise BenchmarkError(
            "In this process the problem is another one than where the comparison was planned: its bounds or costs"
            " differ. A problem must not draw anything when it is imported or made; give it a seed."
        )


def fingerprint(problem: BenchmarkProblem) -> str:
    """Fingerprint of a problem: its bounds and the values of one candidate."""
    values = problem.values(problem.sample_uniform(np.random.default_rng(PROBE_SEED)))
    bounds = [] if problem.mixed else [problem.lower, problem.upper]
    numbers = np.concatenate([*bounds, *(value.ravel() for value in values.values())])
    return " ".join(f"{number:.{PROBE_DIGITS}g}" for number in numbers)


def run(problem: BenchmarkProblem, solver: Solver, task: Task) -> BenchmarkRun:
    """Run a solver until it stops, its budget or its time is used up, or it fails."""
    from robolaser.algorithms.seeding import seeded  # noqa: PLC0415 - pymoo takes a second to import

    limits = task.limits
    evaluator = BudgetedEvaluator(problem, limits, task.spill)
    began, reason, state = time.process_time(), "", DONE
    try:
        with np.errstate(all="ignore"):
            solver.search(evaluator, task.seed)
    except BudgetExhausted:
        pass
    except (Exception, SystemExit) as error:
        if evaluator.left:  # else it caught the end of the budget, and failed after that
            reason, state = _reason(error), FAILED
    if evaluator.out_of_time:
        reason = f"ended by its time limit of {limits.time_limit_s:g} s"
    seconds, processor_s, trace = evaluator.seconds(), time.process_time() - began, evaluator.trace()
    if limits.noisy and len(evaluator.x):
        with seeded(task.seed):
            cost = returned_cost(problem, evaluator.x)
        trace = ConvergenceTrace.of([(evaluator.evaluations, seconds, cost)])
    violation = evaluator.violation if np.isfinite(evaluator.violation) else 0.0
    return BenchmarkRun(
        *task.key, state, reason, evaluator.evaluations, seconds, processor_s, trace, violation, evaluator.x.tolist()
    )


def returned_cost(problem: BenchmarkProblem, x: Any) -> float:
    """Cost of a candidate (1, d) of a noisy problem: `exact` of the problem, or the median of new evaluations."""
    exact = getattr(problem.question, "exact", None)
    if exact is not None:
        return float(np.ravel(exact(x))[0])
    return float(np.median([problem.values(x)["F"][0, 0] for _ in range(REPEATS)]))


def _reason(error: BaseException) -> str:
    if isinstance(error, MemoryError):
        return "it needed more memory than there is"
    if isinstance(error, SystemExit):
        return f"it called sys.exit({error.code!r})"
    if isinstance(error, RobolaserError):
        return str(error)
    return f"{type(error).__name__}: {error}".strip().removesuffix(":")
