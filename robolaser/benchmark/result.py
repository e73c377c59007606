"""The result of a comparison: its problems, its solvers, and every run, also as arrays."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.benchmark.measures import TOLERANCE, tolerances
from robolaser.benchmark.problem import INFEASIBLE, ProblemSummary
from robolaser.benchmark.run import FAILED, BenchmarkRun

if TYPE_CHECKING:
    import pandas as pd


@final
@dataclass(frozen=True, eq=False)
class ResultArrays:
    """All runs on some problems as arrays: problems p, algorithms a, seeds s, targets t.

    NaN is a missing run: not yet made, or the solver does not apply to the problem.

    A failed run counts as if it had spent the budget.
    """

    problems: tuple[str, ...]  # p
    algorithms: tuple[str, ...]  # a
    seeds: tuple[int, ...]  # s
    tolerances: Array  # of the targets, falling, (t,)
    headline: int  # index of the one for the ranking
    evaluations: Array  # to each target, infinite where it was not reached, (p, a, s, t)
    total_evaluations: Array  # by the whole run, (p, a, s)
    total_s: Array  # wall time of the whole run [s], (p, a, s)
    final: Array  # tolerance of the lowest cost; infeasible: `INFEASIBLE` times (1 + the violation), (p, a, s)
    failed: Bools  # (p, a, s)
    noisy: Bools  # problems whose runs are ranked by their final candidates, (p,)

    @property
    def there(self) -> Bools:
        """Runs that were made, (p, a, s)."""
        return np.asarray(~np.isnan(self.total_s))


def outcomes(running_times: Array, final: Array) -> Array:
    """Ranks of all runs on each problem, from 1, with ties: times and final excesses (p, a, s).

    Runs that reached the target come first, the faster the better; then the others by their final cost; last those
    without a result; NaN where there is no run. Hansen et al. 2021 (COCO) rank like this where targets are
    not always reached.
    """
    places = np.full(running_times.shape, np.nan)
    for of_problem, time, excess in zip(places, running_times, final, strict=True):
        there, reached = ~np.isnan(time), np.isfinite(time)
        excess_of_rest = np.where(reached, -np.inf, np.where(np.isnan(excess), np.inf, excess))
        keys = np.stack([excess_of_rest[there], np.where(reached, time, 0.0)[there]], axis=1)
        if len(keys):
            of_problem[there] = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1) + 1.0
    return places


@final
@dataclass(frozen=True, eq=False, repr=False)
class BenchmarkResult:
    """The plan, and every run so far.

    Attributes:
        problems: The problems.
        solvers: Title of each by name, in the given order.
        know_budget: Those whose search depends on the budget.
        refused: Why a solver does not apply to a problem, by (problem, solver).
        seeds: Of the runs: each solver has a run with each on each problem.
        budget: Evaluations of a run, as stated: 20000, or 1000d for a thousand times the number of variables.
        target: The stated tolerance for the ranking.
        time_limit_s: Wall time of a run [s].
        runs: The runs that were made; of several objectives their costs are IGD+.
        made: The same with the original objectives as costs.
        engine: Executor of the runs.
        workers: Runs at a time.
        seconds: Wall time, over all sessions.
        journal: The lines of runs.jsonl.
    """

    problems: tuple[ProblemSummary, ...]
    solvers: Mapping[str, str]
    know_budget: frozenset[str]
    refused: Mapping[tuple[str, str], str]
    seeds: tuple[int, ...]
    budget: str
    target: float | None
    time_limit_s: float
    runs: tuple[BenchmarkRun, ...]
    made: tuple[BenchmarkRun, ...]
    engine: str
    workers: int
    seconds: float
    journal: str = field(default="", repr=False)

    @property
    def families(self) -> tuple[str, ...]:
        """Families of the problems, in order."""
        return tuple(dict.fromkeys(problem.family for problem in self.problems))

    @property
    def wanted(self) -> int:
        """Number of planned runs."""
        return (len(self.problems) * len(self.solvers) - len(self.refused)) * len(self.seeds)

    @cached_property
    def failures(self) -> tuple[BenchmarkRun, ...]:
        """The runs that failed."""
        return tuple(run for run in self.runs if run.state == FAILED)

    def of(self, family: str) -> tuple[ProblemSummary, ...]:
        """The problems of a family."""
        return tuple(problem for problem in self.problems if problem.family == family)

    def arrays(self, family: str) -> ResultArrays:
        """Runs on the problems of a family as arrays, without solvers that apply to none of them."""
        problems = self.of(family)
        names = [problem.name for problem in problems]
        algorithms = [one for one in self.solvers if any((name, one) not in self.refused for name in names)]
        aims = tolerances(family, self.target)
        shape = (len(names), len(algorithms), len(self.seeds))
        evaluations = np.full((*shape, len(aims)), np.nan)
        total_evaluations, total_s, final = (np.full(shape, np.nan) for _ in range(3))
        failed = np.zeros(shape, dtype=bool)
        for run in self.runs:
            if run.problem not in names or run.algorithm not in algorithms or run.seed not in self.seeds:
                continue
            at = names.index(run.problem), algorithms.index(run.algorithm), self.seeds.index(run.seed)
            problem = problems[at[0]]
            evaluations[at] = run.trace.first_hits(problem.best + aims * problem.scale)[0]
            failed[at] = run.state == FAILED
            total_evaluations[at] = problem.budget if failed[at] else run.evaluations
            total_s[at] = run.seconds
            found = run.trace.final
            final[at] = (found - problem.best) / problem.scale if np.isfinite(found) else np.inf
            if run.violation and not np.isfinite(found):
                final[at] = INFEASIBLE * (1.0 + run.violation)
        return ResultArrays(
            problems=tuple(names),
            algorithms=tuple(algorithms),
            seeds=self.seeds,
            tolerances=aims,
            headline=int(np.argmin(np.abs(np.log(aims / (self.target or TOLERANCE))))),
            evaluations=evaluations,
            total_evaluations=total_evaluations,
            total_s=total_s,
            final=final,
            failed=failed,
            noisy=np.array([one.noisy for one in problems]),
        )

    def to_frame(self, of: Literal["runs", "targets"] = "runs") -> "pd.DataFrame":
        """The runs as a table.

        Args:
            of: Which table: of runs, or of runs and targets as in runs.csv.

        Returns:
            Rows in the order of problem, algorithm and seed. Of "runs" a row for each run: `problem`, `family`,
            `dimension`, `algorithm`, `seed`, `state` ("done" or "failed"), `reason`, `evaluations`, `seconds`,
            `processor_s`, `best` (lowest cost, of several objectives IGD+; infinite if nothing feasible was found),
            `violation`, and of the problem `lowest` (the lowest cost known). Of "targets" a row for each run and
            target: `problem`, `algorithm`, `seed`, `state`, `reason`, `tolerance`, `target` (its cost), `reached`
            ("yes" or "no"), `evaluations` and `seconds` to it (missing if it was not reached), and `run_evaluations`,
            `run_seconds`, `run_processor_s`, `run_best`, `run_violation` of the whole run.
        """
        import pandas as pd  # noqa: PLC0415 - a third of a second

        problems = {problem.name: problem for problem in self.problems}
        runs = sorted(self.runs, key=lambda run: run.key)
        if of == "runs":
            rows = [
                {"problem": run.problem, "family": problems[run.problem].family,
                 "dimension": problems[run.problem].dimension, "algorithm": run.algorithm, "seed": run.seed,
                 "state": run.state, "reason": run.reason, "evaluations": run.evaluations, "seconds": run.seconds,
                 "processor_s": run.processor_s, "best": run.trace.final, "violation": run.violation,
                 "lowest": problems[run.problem].best}
                for run in runs
            ]  # fmt: skip
            return pd.DataFrame(rows)
        return pd.DataFrame([row for run in runs for row in _targets(run, problems[run.problem], self.target)])


def _targets(run: BenchmarkRun, problem: ProblemSummary, target: float | None) -> list[dict[str, object]]:
    at = tolerances(problem.family, target)
    costs = problem.best + at * problem.scale
    evaluations, seconds = run.trace.first_hits(costs)
    return [
        {"problem": run.problem, "algorithm": run.algorithm, "seed": run.seed, "state": run.state,
         "reason": run.reason, "tolerance": at[i], "target": costs[i],
         "reached": "yes" if np.isfinite(evaluations[i]) else "no",
         "evaluations": int(evaluations[i]) if np.isfinite(evaluations[i]) else None,
         "seconds": seconds[i] if np.isfinite(seconds[i]) else None,
         "run_evaluations": run.evaluations, "run_seconds": run.seconds, "run_processor_s": run.processor_s,
         "run_best": run.trace.final, "run_violation": run.violation}
        for i in range(len(at))
    ]  # fmt: skip
