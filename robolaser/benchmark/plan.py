"""Which solvers run on which problems, with which seeds and limits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.benchmark.defaults import BUDGET, MEMORY_LIMIT_B, SEEDS, TIME_LIMIT_S
from robolaser.benchmark.problem import CALIBRATION, PROBE_SEED, PROBES, BenchmarkProblem
from robolaser.benchmark.problem_spec import ProblemSpec
from robolaser.benchmark.problem_specs import specs_of
from robolaser.benchmark.solvers import DEFAULT, find
from robolaser.benchmark.solvers.solver import Solver
from robolaser.benchmark.task import Task
from robolaser.errors import UsageError

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
    """

    specs: tuple[ProblemSpec, ...]
    solvers: tuple[Solver, ...]
    seeds: tuple[int, ...]
    budget: int
    time_limit_s: float
    memory_limit_b: int

    @classmethod
    def of(
        cls,
        problems: Sequence[object],
        algorithms: Sequence[str] = DEFAULT,
        *,
        seeds: int = SEEDS,
        first_seed: int = 1,
        budget: int = BUDGET,
        time_limit_s: float = TIME_LIMIT_S,
        memory_limit_b: int = MEMORY_LIMIT_B,
    ) -> "RunPlan":
        """Plan a benchmark of problems and solvers by name.

        Args:
            problems: See `problem_specs.spec_of`.
            algorithms: See `solvers.find`; one that is named twice takes part once.
            seeds: Number of seeds.
            first_seed: The first of them, at least 1; the others follow it.
            budget: Evaluations a run may spend.
            time_limit_s: Wall time a run may take [s].
            memory_limit_b: Memory a run may take [B].

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
        return cls(
            specs_of(problems),
            tuple(find(name) for name in dict.fromkeys(algorithms)),
            tuple(range(first_seed, first_seed + seeds)),
            budget,
            time_limit_s,
            memory_limit_b,
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
            Task(spec.name, solver.name, seed, self.budget, self.time_limit_s, self.memory_limit_b)
            for seed in self.seeds
            for spec in self.specs
            for solver in self.solvers
            if (spec.name, solver.name) not in self.refused
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
    """What identifies a problem besides its name: its bounds, and the costs of some candidates."""
    probes = problem.sample_uniform(np.random.default_rng(PROBE_SEED), PROBES)
    numbers = np.concatenate([problem.lower, problem.upper, problem.cost(probes).ravel()])
    return " ".join(f"{number:.{PROBE_DIGITS}g}" for number in numbers)
