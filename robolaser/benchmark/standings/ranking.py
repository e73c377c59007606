"""Standings of solvers, computed from their runs: on one problem, and on all of a family."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.benchmark.problem import INFEASIBLE
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import HEADLINE, ResultArrays
from robolaser.benchmark.standings import significance
from robolaser.benchmark.standings.answer import answer
from robolaser.benchmark.standings.effects import effects
from robolaser.benchmark.standings.table import (
    FinalCosts,
    Measure,
    OnProblem,
    Order,
    Pair,
    Reached,
    Result,
    Standing,
    Standings,
)
from robolaser.benchmark.statistics import difference, ecdf, mean_ranks, running_time, superiority
from robolaser.benchmark.statistics.intervals import IntervalEstimate, Intervals, finite
from robolaser.benchmark.statistics.outcome import outcomes
from robolaser.benchmark.statistics.quantiles import quantiles
from robolaser.benchmark.statistics.success import wilson

UNKNOWN = IntervalEstimate(None)
Reasons = Mapping[tuple[str, str], str]
"""Why a solver has no runs on a problem, or not all, by (problem, solver)."""


def standings(result: BenchmarkResult, family: str, *, seed: int = 1) -> Standings:
    """Rank the solvers on a family of problems; `seed` is that of the bootstrap samples."""
    dropped = {
        (problem.name, name): f"dropped from the race after {count} seeds"
        for problem in result.of(family)
        for name, count in result.dropped.items()
    }
    return standings_of(result.arrays(family), family=family, refused={**result.refused, **dropped}, seed=seed)


def standings_of(arrays: ResultArrays, *, family: str, refused: Reasons, seed: int = 1) -> Standings:
    """Rank the solvers, given their runs as arrays."""
    drawn = running_time.draws(len(arrays.problems), len(arrays.seeds), np.random.default_rng(seed))
    evaluations, seconds = (_Measured.of(arrays, measure, drawn) for measure in ("evaluations", "seconds"))
    everywhere, headline = range(len(arrays.problems)), arrays.target(HEADLINE)
    return Standings(
        family=family,
        tolerance=HEADLINE,
        seeds=len(arrays.seeds),
        evaluations=evaluations.order(everywhere, refused),
        seconds=seconds.order(everywhere, refused),
        by_problem=tuple(
            OnProblem(
                problem=name,
                evaluations=evaluations.order([p], refused),
                seconds=seconds.order([p], refused),
                results=tuple(
                    _result(arrays, evaluations.expected, seconds.expected, p, a) for a in range(len(arrays.algorithms))
                ),
            )
            for p, name in enumerate(arrays.problems)
        ),
        effects=effects(
            arrays.algorithms, evaluations.places, evaluations.expected.value[..., headline], evaluations.samples
        ),
        scope=significance.SCOPE,
    )


@final
@dataclass(frozen=True, eq=False)
class _Measured:
    """A family's runs in one measure: problems p, algorithms a, seeds s, targets t, bootstrap samples b."""

    arrays: ResultArrays
    measure: Measure
    times: Array  # to each target, (p, a, s, t)
    totals: Array  # of whole runs, (p, a, s)
    places: Array  # of runs on their problem, (p, a, s)
    expected: Intervals  # running times to each target, (p, a, t)
    samples: Array  # the same to the headline target in bootstrap samples, (p, a, b)
    p_adjusted: Array  # for all pairs on all problems, (p, a, a)

    @classmethod
    def of(cls, arrays: ResultArrays, measure: Measure, drawn: Ints) -> "_Measured":
        times, totals = arrays.measured(measure)
        headline = arrays.target(HEADLINE)
        places = outcomes(times[..., headline], arrays.final)
        expected, samples = running_time.expected(times, totals), running_time.resampled(times, totals, drawn)
        runs = np.broadcast_to(arrays.there.sum(axis=2)[..., None], expected.shape)
        return cls(
            arrays,
            measure,
            times,
            totals,
            places,
            running_time.bounds(expected, samples, runs),
            samples[:, :, headline],
            difference.holm_pairs(difference.rank_sum(places)),
        )

    def order(self, problems: Sequence[int], refused: Reasons) -> Order:
        """Rank the solvers on some of the problems."""
        arrays, at = self.arrays, list(problems)
        names, headline = arrays.algorithms, arrays.target(HEADLINE)
        runs = arrays.there[at].sum(axis=2)
        reached = np.isfinite(self.times[at][..., headline]).sum(axis=2)
        unranked = _unranked(arrays, at, runs, refused)
        ranked = [a for a, name in enumerate(names) if name not in unranked]
        blocks = mean_ranks.complete(self.places[at][:, ranked])
        if not len(blocks):
            unranked |= {names[a]: "no seed has a run of every algorithm" for a in ranked}
            ranked = []
        mean = {a: float(rank) for a, rank in zip(ranked, mean_ranks.mean_ranks(blocks), strict=bool(ranked))}
        ordered = sorted(range(len(names)), key=lambda a: (a not in mean, mean.get(a, -runs[:, a].sum()), names[a]))
        pairs = self._pairs(at, ordered, runs, reached > 0)
        areas = self._areas(at)
        places = tuple(
            Standing(
                algorithm=names[a],
                rank=1 + sum(other < mean[a] - 1e-9 for other in mean.values()) if a in mean else None,
                mean_rank=mean.get(a),
                runs=int(runs[:, a].sum()),
                failed=int(arrays.failed[at, a].sum()),
                success=wilson(reached[:, a].sum(), runs[:, a].sum()).at(),
                running_time=self.expected.at(at[0], a, headline) if len(at) == 1 else UNKNOWN,
                solved=int((reached[:, a] > 0).sum()),
                area=finite(areas[a]),
                against_first=pairs.get((ordered[0], a)) if a in mean else None,
                unranked=unranked.get(names[a], ""),
            )
            for a in ordered
        )
        if len(at) == 1:  # comparisons for which p is corrected
            comparisons = int((~np.isnan(self.p_adjusted)).sum()) // 2
        else:
            made = (runs[:, :, None] > 0) & (runs[:, None, :] > 0)
            comparisons = int(np.triu(made.any(axis=0), 1).sum())
        order = [a for a in ordered if a in mean]
        differ = {(one, other) for (one, other), pair in pairs.items() if pair.significant}
        alike = np.array([[not {(a, b), (b, a)} & differ for b in order] for a in order], bool)
        return Order(
            measure=self.measure,
            problems=tuple(arrays.problems[p] for p in at),
            places=places,
            pairs=tuple(pairs.values()),
            blocks=len(blocks),
            groups=tuple(tuple(names[order[i]] for i in group) for group in mean_ranks.groups(alike)),
            answer=answer(
                self.measure,
                places,
                problems=len(at),
                runs=int(runs[:, ranked].min()) if ranked else 0,
                comparisons=comparisons,
            ),
        )

    def _pairs(self, at: list[int], ordered: list[int], runs: Ints, solved: Bools) -> dict[tuple[int, int], Pair]:
        """Each with each, the one that stands before first."""
        names, places = self.arrays.algorithms, self.places[at]
        expected = self.expected.value[at][..., self.arrays.target(HEADLINE)]
        better = superiority.mean_superiority(superiority.superiority(places))
        ratios = running_time.mean_ratios(self.samples[at], expected, runs)
        p = difference.stratified(places)
        adjusted = self.p_adjusted[at[0]] if len(at) == 1 else difference.holm_pairs(p)
        found = {}
        for one, other in combinations(ordered, 2):
            both = np.flatnonzero(solved[:, one] & solved[:, other])
            superior = better.at(one, other)
            found[one, other] = Pair(
                one=names[one],
                other=names[other],
                superiority=superior,
                effect=None if superior.value is None else significance.effect(superior.value),
                ratio=ratios.at(one, other) if len(both) else UNKNOWN,
                ratio_problems=tuple(self.arrays.problems[at[i]] for i in both),
                p=finite(p[one, other]),
                p_adjusted=finite(adjusted[one, other]),
                significant=significance.is_significant(float(adjusted[one, other])),
            )
        return found

    def _areas(self, at: list[int]) -> Array:
        budgets = ecdf.budgets(self.times[at], self.totals[at], points=2)
        if not len(budgets) or budgets[-1] <= budgets[0]:
            return np.full(self.times.shape[1], np.nan)
        return ecdf.areas(self.times[at], float(budgets[0]), float(budgets[-1]))


def _unranked(arrays: ResultArrays, at: list[int], runs: Ints, refused: Reasons) -> dict[str, str]:
    """Who lacks so many runs that the others would have to be ranked on what little is left, and why."""
    found: dict[str, str] = {}
    for i, p in enumerate(at):
        problem, most = arrays.problems[p], int(runs[i].max(initial=0))
        for name, there in zip(arrays.algorithms, runs[i].tolist(), strict=True):
            reason = refused.get((problem, name))
            if reason or there < significance.ENOUGH * most or not most:
                found.setdefault(name, reason or f"it has {there} of {len(arrays.seeds)} runs on {problem}")
    return found


def _result(arrays: ResultArrays, evaluations: Intervals, seconds: Intervals, p: int, a: int) -> Result:
    runs, final = int(arrays.there[p, a].sum()), arrays.final[p, a]
    reached = np.isfinite(arrays.evaluations[p, a]).sum(axis=0)
    shares = wilson(reached, np.full(reached.shape, runs))
    infeasible = final[(final >= INFEASIBLE) & np.isfinite(final)]
    ends = quantiles(np.where(final >= INFEASIBLE, np.inf, final), np.array([0.0, 0.25, 0.5, 0.75, 1.0]))
    return Result(
        problem=arrays.problems[p],
        algorithm=arrays.algorithms[a],
        runs=runs,
        failed=int(arrays.failed[p, a].sum()),
        final=FinalCosts(*map(finite, ends)) if runs else None,
        violation=float(np.median(infeasible)) / INFEASIBLE - 1.0 if len(infeasible) else None,
        targets=tuple(
            Reached(float(tolerance), int(reached[t]), shares.at(t), evaluations.at(p, a, t), seconds.at(p, a, t))
            for t, tolerance in enumerate(arrays.tolerances)
        ),
    )
