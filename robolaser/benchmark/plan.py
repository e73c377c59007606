"""Which solvers run on which problems, with which seeds and limits."""

import math
import pickle
import re
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Literal, final

from robolaser.algorithms.user_code import Given, by_name
from robolaser.benchmark.evaluator import RunLimits
from robolaser.benchmark.executors import PACKAGES
from robolaser.benchmark.named_problems import specs_of
from robolaser.benchmark.problem import BenchmarkProblem, ProblemSpec, ProblemSummary
from robolaser.benchmark.run import Task, fingerprint
from robolaser.benchmark.solvers import find
from robolaser.benchmark.solvers.solver import Solver
from robolaser.errors import UsageError
from robolaser.plugins import extra

OUR_SEEDS = (1, 2, 3)  # of the search for the lowest cost of a calibration, outside the comparison
SLOW_S = 0.02  # time of a candidate from which the time limit is checked after each, also within batches


@final
@dataclass(frozen=True)
class Terms:
    """The arguments of `compare` that apply to every run."""

    seeds: tuple[int, ...]  # the same for all: solvers with one initial sampling start from the same candidates
    budget: int | str
    target: float | None
    time_limit_s: float
    on_error: Literal["fail", "inf"]

    def __post_init__(self) -> None:
        """Raise a `UsageError` if a number makes no sense."""
        for what, value in (("seeds", len(self.seeds)), ("time_limit_s", self.time_limit_s), ("target", self.target)):
            if value is not None and not 0 < value < math.inf:
                raise UsageError(f"compare: {what} is {value!r}, expected a finite number above 0.")
        if min(self.seeds) < 1:
            raise UsageError(f"compare: first_seed is {min(self.seeds)}, expected at least 1.")
        if self.on_error not in ("fail", "inf"):
            raise UsageError(f"compare: on_error is {self.on_error!r}, expected 'fail' or 'inf'.")
        self.evaluations(1)

    def evaluations(self, dimension: int) -> int:
        """Budget of a run on a problem of so many variables."""
        match = re.fullmatch(r"(\d+(?:\.\d+)?(?:e\d+)?)(d?)", str(self.budget).strip())
        found = float(match[1]) * (dimension if match[2] else 1) if match else 0.0
        if not 0.5 < found < math.inf:
            raise UsageError(
                f"budget is {self.budget!r}, expected a number of evaluations, as 20000, or of evaluations for each"
                " variable, as 1000d."
            )
        return round(found)


@final
@dataclass(frozen=True, eq=False)
class BenchmarkPlan:
    """Every solver runs once with each seed on every problem that it applies to."""

    terms: Terms  # of every run
    problems: tuple[ProblemSummary, ...]  # the problems
    solvers: Mapping[str, Solver]  # the solvers by name
    refused: Mapping[tuple[str, str], str]  # why a solver does not apply to a problem, by (problem, solver)
    tasks: tuple[Task, ...]  # all runs, those with the first seed first: stopping early is then fair to all solvers

    @classmethod
    def of(cls, problems: Given, algorithms: Given, terms: Terms) -> "BenchmarkPlan":
        """Find problems and algorithms, and test whether each problem is noisy or slow.

        Raises:
            UsageError: There is no such problem, algorithm or setting, or one cannot be compared on or pickled.
            BenchmarkError, DataError, DependencyMissing: A problem cannot be built, or cloudpickle is not installed.
        """
        if not problems or not algorithms:
            raise UsageError("compare: expected at least one problem and one algorithm.")
        solvers = by_name(algorithms, find, 'compare(…, {"small": GA(pop_size=20), "large": GA(pop_size=50)})')
        pickles = {name: _pickled(solver, name) for name, solver in solvers.items()}
        summaries, refused, first = [], {}, []
        for spec in specs_of(problems):
            problem, limits = _planned(spec, terms)
            sent, fingerprint = _pickled(spec, spec.name), "" if limits.noisy else problem.summary.fingerprint
            summaries.append(problem.summary)
            for name, solver in solvers.items():
                if (reason := solver.refuses(problem)) is not None:
                    refused[problem.name, name] = reason
                else:
                    first.append(Task(problem.name, name, 0, limits, sent, pickles[name], fingerprint))
        tasks = tuple(replace(task, seed=seed) for seed in terms.seeds for task in first)
        return cls(terms, tuple(summaries), solvers, refused, tasks)

    def to_dict(self) -> dict[str, Any]:
        """The plan's entry in a journal, without the engine."""
        names = {name.partition(":")[0] for name in self.solvers}
        packages = [*PACKAGES, *(["cma"] if names & {"pycma", "cmaes"} else [])]
        return {
            "conditions": {
                "budget": str(self.terms.budget),
                "time_limit_s": self.terms.time_limit_s,
                "on_error": self.terms.on_error,
                **{f"version of {package}": _version(package) for package in packages},
            },
            "problems": [
                {name: value for name, value in asdict(one).items() if name != "best"}  # known after the runs
                for one in self.problems
            ],
            "solvers": [[name, solver.title, solver.knows_budget] for name, solver in self.solvers.items()],
            "refused": [[problem, name, reason] for (problem, name), reason in self.refused.items()],
            "seeds": list(self.terms.seeds),
            "target": self.terms.target,
        }


def _planned(spec: ProblemSpec, terms: Terms) -> tuple[BenchmarkProblem, RunLimits]:
    """A problem with fingerprint, noise and lowest known cost, and the limits of runs on it."""
    problem, first, noisy, began = spec.made_for(1), "", False, time.perf_counter()
    try:
        first = fingerprint(problem)
        noisy = fingerprint(problem) != first
    except Exception as error:  # whatever a user's problem raises
        if terms.on_error == "fail":
            raise UsageError(
                f"{spec.name} fails at a random candidate ({type(error).__name__}: {error}). If that happens to some"
                " candidates only, --on-error inf lets these cost infinity."
            ) from error
    slow = time.perf_counter() - began > SLOW_S
    if noisy and problem.n_obj > 1:
        raise UsageError(f"{spec.name} is noisy and has several objectives: such problems cannot be compared on yet.")
    budget, lowest = terms.evaluations(problem.dimension), problem.summary.lowest
    if lowest is None and problem.model is not None:
        from robolaser.estimation.multistart import multistart  # noqa: PLC0415 - only calibrations need it

        lowest = min(multistart(problem.model, seed=seed).cost for seed in OUR_SEEDS)
    seen = f"{problem.lower} {problem.upper}" if noisy else first
    summary = replace(problem.summary, budget=budget, noisy=noisy, lowest=lowest, fingerprint=seen)
    limits = RunLimits(budget, terms.time_limit_s, terms.on_error == "inf", one_by_one=slow, noisy=noisy)
    return replace(problem, summary=summary), limits


def _pickled(thing: Any, name: str) -> bytes:
    """Pickle an object; those of `__main__` or without an importable name by value, with cloudpickle."""
    try:
        found = pickle.dumps(thing)
        if b"__main__" not in found:
            return found
    except Exception:  # lambdas, local classes
        pass
    cloudpickle = extra(
        "cloudpickle",
        f"{name} is defined in a script or a notebook, and other processes need cloudpickle to get it:"
        " pip install 'robolaser[compare]'. Or move it to a module of its own.",
    )
    try:
        return bytes(cloudpickle.dumps(thing))
    except Exception as error:
        raise UsageError(
            f"{name} cannot be sent to another process ({type(error).__name__}: {error}). Leave out what it holds open"
            " (files, connections), or open that at the first evaluation."
        ) from error


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"
