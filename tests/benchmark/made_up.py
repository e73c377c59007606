"""Synthetic comparisons: random traces with known statistics."""

from collections.abc import Mapping

import numpy as np

from robolaser.benchmark.evaluator import ConvergenceTrace
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.run import DONE, FAILED, BenchmarkRun

BUDGET = 10_000


def made_up_run(
    algorithm: str, seed: int, *, problem: str = "paper", speed: float = 1.0, reason: str = ""
) -> BenchmarkRun:
    """A run that comes ten times closer to zero about every `100 / speed` evaluations."""
    rng = np.random.default_rng([sum(map(ord, algorithm + problem)), seed])
    costs = 10.0 ** -np.arange(-3.0, 7.0)
    evaluations = np.cumsum(rng.integers(1, 200, len(costs)) / speed).astype(int) + 1
    kept = evaluations <= BUDGET
    trace = ConvergenceTrace(evaluations[kept], evaluations[kept] * 1e-4, costs[kept])
    state = FAILED if reason else DONE
    return BenchmarkRun(problem, algorithm, seed, state, reason, BUDGET, BUDGET * 1e-4, BUDGET * 1e-4, trace)


def made_up_comparison(
    speeds: Mapping[str, float], *, seeds: int = 5, problems: tuple[str, ...] = ("paper", "reduced:paper")
) -> BenchmarkResult:
    """Solvers of different speeds on problems with a best cost of zero."""
    runs = tuple(
        made_up_run(name, seed, problem=problem, speed=speed)
        for problem in problems
        for name, speed in speeds.items()
        for seed in range(1, seeds + 1)
    )
    return BenchmarkResult(
        problems=tuple(
            ProblemSummary(name, name, "calibration", 14, 1, "m²", BUDGET, floor=1.0, found_by="theory", best=0.0)
            for name in problems
        ),
        solvers={name: f"the {name}" for name in speeds},
        know_budget=frozenset(),
        refused={},
        seeds=tuple(range(1, seeds + 1)),
        budget=str(BUDGET),
        target=None,
        time_limit_s=60.0,
        runs=runs,
        made=runs,
        engine="this machine",
        workers=2,
        seconds=1.0,
    )


def outcomes(result):
    """What became of each run, without its time."""
    return {
        run.key: (run.state, run.reason, run.trace.evaluations.tolist(), run.trace.costs.tolist())
        for run in result.runs
    }
