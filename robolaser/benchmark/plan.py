"""Which solvers run on which problems, with which seeds and limits."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import final

import cloudpickle
import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.defaults import BUDGET, MEMORY_LIMIT_B, SEEDS, TIME_LIMIT_S
from robolaser.benchmark.problem import CALIBRATION, PROBE_SEED, PROBES, BenchmarkProblem, ProblemSpec
from robolaser.benchmark.problem_specs import specs_of
from robolaser.benchmark.single_run import Task
from robolaser.benchmark.solvers import DEFAULT, find
from robolaser.benchmark.solvers.solver import Solver
from robolaser.errors import UsageError

MAIN = "__main__"
"""Module of a script or a notebook, which no other process can import."""
OUR_OWN = "robolaser's own search"
"""Found the lowest cost, if no solver came below it."""
THEORY = "theory"
OUR_SEEDS = (1, 2, 3)
"""Seeds of our own search for the lowest cost, outside the benchmark."""
PROBE_DIGITS = 9
"""Digits of the costs that identify a problem: another machine may round differently."""


@final
@dataclass(frozen=True, eq=False)
class RunPlan:
    """Every solver runs once with each seed on every problem that it applies to.

    Attributes:
        specs: Of the problems.
        solvers: The solvers to be compared.
        seeds: The same for all: solvers that draw their first candidates alike begin with the same ones.
        budget: Evaluations a run may spend.
        time_limit_s: Wall time a run may take [s].
        memory_limit_b: Memory a run may take beyond what its process needs anyway [B].
        pickled: Solvers that another process cannot find by their names, pickled.
        dropped: After how many seeds a race dropped a solver.

    Examples:
        >>> plan = robolaser.RunPlan.of(["pymoo:sphere-2"], ["de", "pso"], seeds=3, budget=500)
        >>> len(plan.tasks)
        6
    """

    specs: tuple[ProblemSpec, ...]
    solvers: tuple[Solver, ...]
    seeds: tuple[int, ...]
    budget: int
    time_limit_s: float
    memory_limit_b: int
    pickled: Mapping[str, bytes] = field(default_factory=dict)
    dropped: Mapping[str, int] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        problems: Sequence[object],
        algorithms: Sequence[object] = DEFAULT,
        *,
        seeds: int = SEEDS,
        first_seed: int = 1,
        budget: int = BUDGET,
        time_limit_s: float = TIME_LIMIT_S,
        memory_limit_b: int = MEMORY_LIMIT_B,
        starts: Mapping[str, Array] | None = None,
    ) -> "RunPlan":
        """Plan a benchmark of problems and solvers by name.

        Args:
            problems: See `problem_specs.spec_of`.
            algorithms: Names, see `solvers.find`, or functions, classes and instances; who comes twice takes part once.
            seeds: Number of seeds.
            first_seed: The first of them, at least 1; the others follow it.
            budget: Evaluations a run may spend.
            time_limit_s: Wall time a run may take [s].
            memory_limit_b: Memory a run may take [B].
            starts: Candidates that every solver begins with, (k, d), by problem; see `table.starting_points`.

        Raises:
            UsageError: There is no such problem, algorithm or setting, or a number is not above 0.
            BenchmarkError, DataError: A problem cannot be built.
        """
        for what, value in (
            ("problems", len(problems)),
            ("algorithms", len(algorithms)),
            ("seeds", seeds),
            ("first_seed", first_seed),
            ("budget", budget),
            ("time_limit_s", time_limit_s),
            ("memory_limit_b", memory_limit_b),
        ):
            if not value > 0:
                raise UsageError(f"RunPlan: {what} is {value!r}, expected more than 0.")
        specs = specs_of(problems)
        found = {given: find(given) for given in dict.fromkeys(algorithms)}
        if len({solver.name for solver in found.values()}) < len(found):
            raise UsageError("RunPlan: two algorithms have one name, and results are stored by name.")
        return cls(
            specs if starts is None else tuple(_starting(spec, starts) for spec in specs),
            tuple(found.values()),
            tuple(range(first_seed, first_seed + seeds)),
            budget,
            time_limit_s,
            memory_limit_b,
            {
                solver.name: cloudpickle.dumps(solver)
                for given, solver in found.items()
                if not isinstance(given, str) or MAIN in given
            },
        )

    @cached_property
    def problems(self) -> tuple[BenchmarkProblem, ...]:
        """The problems, built."""
        return tuple(spec.problem() for spec in self.specs)

    @cached_property
    def refused(self) -> Mapping[tuple[str, str], str]:
        """Why a solver does not apply to a problem, by (problem, solver)."""
        return {
            (problem.name, solver.name): reason
            for problem in self.problems
            for solver in self.solvers
            if (reason := _refusal(solver, problem)) is not None
        }

    @cached_property
    def tasks(self) -> tuple[Task, ...]:
        """All runs, those with the first seed first: a benchmark that is stopped early is fair to all solvers."""
        return tuple(
            Task(
                spec.name,
                solver.name,
                seed,
                self.budget,
                self.time_limit_s,
                self.memory_limit_b,
                self.pickled.get(solver.name, b""),
            )
            for number, seed in enumerate(self.seeds)
            for spec in self.specs
            for solver in self.solvers
            if (spec.name, solver.name) not in self.refused and number < self.dropped.get(solver.name, len(self.seeds))
        )

    @cached_property
    def packages(self) -> tuple[str, ...]:
        """Packages that make the runs, whose other versions may search differently."""
        solvers = {solver.name.partition(":")[0] for solver in self.solvers}
        return (
            *("robolaser", "numpy", "scipy", "pymoo"),
            *(("numba",) if any(problem.family == CALIBRATION for problem in self.problems) else ()),
            *(("cma",) if solvers & {"pycma", "cmaes"} else ()),
        )


def _starting(spec: ProblemSpec, starts: Mapping[str, Array]) -> ProblemSpec:
    """A problem whose solvers begin with candidates of earlier runs."""
    dimension = spec.problem().dimension
    there = starts.get(spec.name, np.empty((0, 0)))
    if there.shape[1:] != (dimension,) or not len(there):
        known = ", ".join(f"{name} ({x.shape[1]})" for name, x in starts.items() if len(x)) or "none"
        raise UsageError(
            f"No earlier run on {spec.name} with {dimension} variables left a candidate to begin with. There are"
            f" candidates on: {known}."
        )
    return ProblemSpec(spec.name, partial(_with_starts, spec.problem, there))


def _with_starts(make: Callable[[], BenchmarkProblem], starts: Array) -> BenchmarkProblem:
    problem = make()
    return replace(problem, starts=np.clip(starts, problem.lower, problem.upper))


def _refusal(solver: Solver, problem: BenchmarkProblem) -> str | None:
    try:
        return solver.refuses(problem)
    except Exception as error:  # a user's own solver
        return f"asked whether it applies, it failed ({type(error).__name__}: {error})"


def best_known(problem: BenchmarkProblem) -> tuple[float, str]:
    """The lowest cost that is known before any run, and who found it."""
    if problem.lowest is not None:
        return problem.lowest, THEORY
    if problem.model is None:
        return np.inf, ""
    from robolaser.estimation.multistart import multistart  # noqa: PLC0415 - only calibrations need it

    return min(multistart(problem.model, seed=seed).cost for seed in OUR_SEEDS), OUR_OWN


def fingerprint(problem: BenchmarkProblem) -> str:
    """What identifies a problem besides its name: its bounds, the costs of some candidates, and its starts."""
    probes = problem.sample_uniform(np.random.default_rng(PROBE_SEED), PROBES)
    numbers = np.concatenate([problem.lower, problem.upper, problem.cost(probes).ravel(), problem.starts.ravel()])
    return " ".join(f"{number:.{PROBE_DIGITS}g}" for number in numbers)
