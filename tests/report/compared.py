"""Synthetic comparisons: random convergence traces instead of searches."""

from dataclasses import replace

import numpy as np

from robolaser.benchmark.evaluator import ConvergenceTrace
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.run import DONE, FAILED, BenchmarkRun
from robolaser.benchmark.standings.ranking import standings

BUDGET = 60_000
LONG = "ga:crossover=ArithmeticCrossover:mutation=NonUniformMutation"
SPEEDS = {
    "screening": ("screened starts, then least squares", 0.05, 1.0, 3e-6),
    "scipy-least-squares": ("SciPy's least squares from many starts", 0.08, 0.97, 3e-6),
    "rcga": ("the paper's real-coded genetic algorithm", 0.9, 0.6, 1.2e-5),
    LONG: ("pymoo's GA with the paper's crossover and mutation", 1.0, 0.55, 2e-5),
    "ga": ("pymoo's GA", 1.6, 0.3, 2e-5),
    "de": ("pymoo's differential evolution", 0.45, 0.9, 1.5e-5),
    "pso": ("pymoo's particle swarm", 0.8, 0.5, 2e-5),
    "g3pcx": ("pymoo's G3PCX", 0.7, 0.35, 2e-5),
}
"""Title, share of the budget that ten decades take, share of runs that end in the right valley, seconds a candidate."""
PROBLEMS = (
    ProblemSummary(
        "paper",
        "the paper's cell, 15 parameters",
        "calibration",
        15,
        1,
        "m²",
        BUDGET,
        floor=1e-12,
        found_by="screening",
        best=6.5e-6,
    ),
    ProblemSummary(
        "ur5",
        "UR5 with a stripe scanner, joint 3 compliant",
        "calibration",
        33,
        1,
        "m²",
        BUDGET,
        floor=1e-12,
        found_by="screening",
        best=2.1e-5,
    ),
    ProblemSummary(
        "rastrigin",
        "Rastrigin's function, shifted",
        "test function",
        10,
        1,
        "",
        BUDGET,
        lowest=0.0,
        found_by="theory",
        best=0.0,
    ),
)


def course(rng, problem, speed, luck, seconds, budget=BUDGET):
    """The trace of a run that falls decade by decade, or stagnates in another valley."""
    stuck = rng.uniform() > luck
    hard = speed * (1.0 + 0.5 * (problem.dimension > 20)) * rng.lognormal(0.0, 0.25)
    evaluations = np.unique(np.geomspace(5, budget, 140).astype(int))
    tolerance = 10 ** (4.0 - 10.0 * evaluations / (budget * hard) + rng.normal(0, 0.1, len(evaluations)))
    tolerance += rng.uniform(0.3, 8.0) if stuck else 0.0
    costs = np.minimum.accumulate(problem.best + problem.scale * np.maximum(tolerance, 0.0))
    better = np.append(True, np.diff(costs) < 0)
    return ConvergenceTrace(evaluations[better], evaluations[better] * seconds, costs[better])


def made(
    names=tuple(SPEEDS), problems=PROBLEMS, seeds=15, failing="g3pcx", refusing="scipy-least-squares", unfinished="pso"
):
    """Every solver on every problem; one fails at times, one refuses the last problem, one is unfinished."""
    rng = np.random.default_rng(4)
    runs, refused = [], {}
    for problem in problems:
        for name in names:
            _, speed, luck, seconds = SPEEDS[name]
            if name == refusing and problem.family == "test function":
                refused[problem.name, name] = "the cost is not a sum of squares, and it needs residuals"
                continue
            for seed in range(1, seeds + 1):
                if name == unfinished and seed > 9:
                    continue
                fails = name == failing and seed % 4 == 0
                path = course(rng, problem, speed, luck, seconds)
                spent = BUDGET
                reason = "not done within 20 s" if seed % 8 else "ValueError: array must not contain infs or NaNs"
                runs.append(
                    BenchmarkRun(problem.name, name, seed, FAILED if fails else DONE, reason if fails else "", spent,
                        spent * seconds, spent * seconds * 0.98, path)
                )  # fmt: skip
    busy = sum(run.seconds for run in runs)
    return BenchmarkResult(
        problems=tuple(problems), solvers={name: SPEEDS[name][0] for name in names},
        know_budget=frozenset({"rcga"} & {*names}), refused=refused, seeds=tuple(range(1, seeds + 1)),
        budget=str(BUDGET), target=None, time_limit_s=20.0, runs=tuple(runs), made=tuple(runs),
        engine="this machine", workers=2, seconds=0.53 * busy,
    )  # fmt: skip


def large():
    return made()


def complete():
    """One family, all runs finished."""
    return made(names=tuple(SPEEDS), problems=PROBLEMS[:2], seeds=8, unfinished="")


def tiny():
    """One solver, one problem, one seed."""
    return made(names=("rcga",), problems=PROBLEMS[:1], seeds=1)


def pair():
    return made(names=("rcga", "de"), problems=PROBLEMS[:1], seeds=5, unfinished="")


def nothing():
    """No finished run."""
    one = made()
    problems = tuple(replace(problem, best=np.inf, found_by="") for problem in one.problems)
    return replace(one, problems=problems, runs=(), made=(), engine="tcp://10.0.0.7:8786", workers=12, seconds=0.4)


def all_fail():
    """Every run fails at its start."""
    one = made(names=("rcga", "de"), problems=PROBLEMS[:2], seeds=3)
    none = ConvergenceTrace(np.zeros(0, np.int64), np.zeros(0), np.zeros(0))
    runs = tuple(
        replace(run, state=FAILED, reason="ImportError: no module named 'x'", evaluations=0, seconds=0.01, trace=none)
        for run in one.runs
    )
    problems = tuple(replace(problem, best=np.inf, found_by="") for problem in one.problems)
    return replace(one, problems=problems, runs=runs, made=runs)


MADE = {"large": large, "complete": complete, "tiny": tiny, "pair": pair, "nothing": nothing, "all_fail": all_fail}
"""Comparisons to report on."""


def judged(comparison):
    """The standings of each family."""
    return tuple(standings(comparison, family) for family in comparison.families)
