"""Standings of solvers, computed from their runs: on one problem, and on all of a family."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import final

import numpy as np
from scipy.stats import rankdata

from robolaser.algorithms.spec import AlgorithmSpec
from robolaser.arrays import Array, Ints
from robolaser.benchmark.problem import INFEASIBLE
from robolaser.benchmark.result import BenchmarkResult, ResultArrays, outcomes
from robolaser.benchmark.standings import table
from robolaser.benchmark.standings.answer import answer
from robolaser.benchmark.statistics import difference, running_time
from robolaser.benchmark.statistics.intervals import IntervalEstimate, finite, wilson
from robolaser.errors import UsageError

ENOUGH = 0.5
"""Share of the largest number of runs on each problem that a ranked solver needs: a block (problem, seed) that one
solver lacks is lost for all."""
SCOPE = (
    "Intervals and tests say what new seeds would change on these very problems, with this budget and on this machine. "
    "They do not say how algorithms do on other problems: for that, compare them on more problems."
)
UNKNOWN = IntervalEstimate(None)
Reasons = Mapping[tuple[str, str], str]  # why a solver has no runs on a problem, or not all, by (problem, solver)


def standings(result: BenchmarkResult, family: str) -> table.Standings:
    """Rank the solvers on a family of problems."""
    return standings_of(result.arrays(family), family=family, refused=result.refused)


def standings_of(arrays: ResultArrays, *, family: str, refused: Reasons) -> table.Standings:
    """Rank the solvers, given their runs as arrays."""
    ranking = _Ranking(arrays)
    return table.Standings(
        family=family,
        tolerance=float(arrays.tolerances[arrays.headline]),
        seeds=len(arrays.seeds),
        order=ranking.order(range(len(arrays.problems)), refused),
        by_problem=tuple(
            table.OnProblem(
                name, ranking.order([p], refused), tuple(ranking.result(p, a) for a in range(len(arrays.algorithms)))
            )
            for p, name in enumerate(arrays.problems)
        ),
        effects=_operator_effects(arrays.algorithms, ranking.places, ranking.expected),
        scope=SCOPE,
    )


@final
class _Ranking:
    """A family's runs: problems p, algorithms a, seeds s, targets t, bootstrap samples b."""

    def __init__(self, arrays: ResultArrays) -> None:
        self.arrays = arrays
        self.times = arrays.evaluations[..., arrays.headline]  # to the target, (p, a, s)
        judged = np.where(arrays.noisy[:, None, None] & ~np.isnan(self.times), np.inf, self.times)
        self.places = outcomes(judged, arrays.final)  # of runs on their problem
        self.expected = running_time.expected(self.times, arrays.total_evaluations)  # (p, a, 1 + b)
        runs = arrays.there.sum(axis=2)
        self.bounded = running_time.bounded(self.expected, runs, runs - 1)  # (p, a)
        self.p_adjusted = difference.holm_pairs(difference.rank_sum(self.places))  # of all problems, (p, a, a)

    def order(self, problems: Sequence[int], refused: Reasons) -> table.Order:
        """Rank the solvers on some of the problems."""
        arrays, at = self.arrays, list(problems)
        names = arrays.algorithms
        runs = arrays.there[at].sum(axis=2)
        reached = np.isfinite(self.times[at]).sum(axis=2)
        unranked = _unranked(arrays, at, runs, refused)
        ranked = [a for a, name in enumerate(names) if name not in unranked]
        blocks = np.moveaxis(self.places[at][:, ranked], 1, 2).reshape(len(at) * len(arrays.seeds), len(ranked))
        blocks = blocks[~np.isnan(blocks).any(axis=1)]
        if not len(blocks):
            unranked |= {names[a]: "no seed has a run of every algorithm" for a in ranked}
            ranked = []
        mean = dict(zip(ranked, rankdata(blocks, axis=1).mean(axis=0).tolist(), strict=True)) if ranked else {}
        ordered = sorted(range(len(names)), key=lambda a: (a not in mean, mean.get(a, -runs[:, a].sum()), names[a]))
        p = difference.stratified(self.places[at])
        corrected = self.p_adjusted if len(at) == 1 else difference.holm_pairs(p)  # over all comparisons made
        adjusted = self.p_adjusted[at[0]] if len(at) == 1 else corrected
        pairs = self._pairs(at, ordered, runs, p, adjusted)
        places = tuple(
            table.Standing(
                algorithm=names[a],
                rank=1 + sum(other < mean[a] - 1e-9 for other in mean.values()) if a in mean else None,
                mean_rank=mean.get(a),
                runs=int(runs[:, a].sum()),
                failed=int(arrays.failed[at, a].sum()),
                success=wilson(int(reached[:, a].sum()), int(runs[:, a].sum())),
                running_time=self.bounded.at(at[0], a) if len(at) == 1 else UNKNOWN,
                solved=int((reached[:, a] > 0).sum()),
                against_first=pairs.get((ordered[0], a)) if a in mean else None,
                unranked=unranked.get(names[a], ""),
            )
            for a in ordered
        )
        comparisons = int((~np.isnan(corrected)).sum()) // 2
        fewest = int(runs[:, ranked].min()) if ranked else 0
        return table.Order(
            problems=tuple(arrays.problems[p] for p in at),
            places=places,
            pairs=tuple(pairs.values()),
            blocks=len(blocks),
            answer=answer(places, problems=len(at), runs=fewest, comparisons=comparisons),
        )

    def result(self, p: int, a: int) -> table.ResultOnProblem:
        """One solver on one problem."""
        arrays, final = self.arrays, self.arrays.final[p, a][self.arrays.there[p, a]]
        infeasible, feasible = final[(final >= INFEASIBLE) & np.isfinite(final)], final < INFEASIBLE
        ends: Sequence[float] = ()
        if len(final):  # all are observed values: runs without a result have infinity
            levels = np.linspace(0.0, 1.0, len(table.FINAL))
            ends = np.quantile(np.where(feasible, final, np.inf), levels, method="inverted_cdf").tolist()
        return table.ResultOnProblem(
            problem=arrays.problems[p],
            algorithm=arrays.algorithms[a],
            runs=len(final),
            failed=int(arrays.failed[p, a].sum()),
            successes=int(np.isfinite(self.times[p, a]).sum()),
            final=dict(zip(table.FINAL, map(finite, ends), strict=True)) if len(final) else None,
            violation=float(np.median(infeasible)) / INFEASIBLE - 1.0 if len(infeasible) else None,
            evaluations=self.bounded.at(p, a),
            run_seconds=float(np.nanmedian(arrays.total_s[p, a])) if len(final) else None,
        )

    def _pairs(
        self, at: list[int], ordered: list[int], runs: Ints, p: Array, adjusted: Array
    ) -> dict[tuple[int, int], table.PairwiseComparison]:
        """All pairs, the better-ranked solver first."""
        names, solved = self.arrays.algorithms, np.isfinite(self.times[at]).sum(axis=2) > 0
        better, ratios = difference.superiority(self.places[at]), running_time.mean_ratios(self.expected[at], runs)
        found = {}
        for one, other in combinations(ordered, 2):
            both = np.flatnonzero(solved[:, one] & solved[:, other])
            found[one, other] = table.PairwiseComparison(
                one=names[one],
                other=names[other],
                superiority=better.at(one, other),
                ratio=ratios.at(one, other),
                ratio_problems=tuple(self.arrays.problems[at[i]] for i in both),
                p=finite(p[one, other]),
                p_adjusted=finite(adjusted[one, other]),
                significant=bool(adjusted[one, other] < difference.LEVEL),
            )
        return found


def _unranked(arrays: ResultArrays, at: list[int], runs: Ints, refused: Reasons) -> dict[str, str]:
    """Solvers that lack too many runs for a ranking on common blocks, with reasons."""
    found: dict[str, str] = {}
    for i, p in enumerate(at):
        problem, most = arrays.problems[p], int(runs[i].max(initial=0))
        for name, there in zip(arrays.algorithms, runs[i].tolist(), strict=True):
            reason = refused.get((problem, name))
            if reason or there < ENOUGH * most or not most:
                found.setdefault(name, reason or f"it has {there} of {len(arrays.seeds)} runs on {problem}")
    return found


def _operator_effects(algorithms: Sequence[str], places: Array, expected: Array) -> tuple[table.OperatorEffect, ...]:
    """The effect of each part that is exchanged in one algorithm and not in another.

    Runs with the part are compared with otherwise equal runs without it: same problem, same other operators.
    The effect is the mean of A12 over these strata, the geometric mean of the ratios of running times, and the p of van
    Elteren's test of the strata. Ranks of runs (p, a, s), expected running times to the headline target, of all runs
    and of bootstrap samples (p, a, 1 + b).
    """
    found = []
    for (stock, slot, operator), pairs in _pairs(algorithms).items():
        with_part, without = np.array(pairs).T
        strata = _strata(places, with_part, without)
        runs = (~np.isnan(strata)).sum(axis=2)
        there = (runs > 0).all(axis=1)
        if not there.any():
            continue
        better = difference.superiority(strata[there]).at(0, 1)
        ratio = running_time.mean_ratios(_strata(expected, with_part, without)[there], runs[there]).at(1, 0)
        p = float(difference.stratified(strata[there])[0, 1])
        found.append(table.OperatorEffect(stock, slot, operator, int(there.sum()), better, ratio, p, p_adjusted=p))
    adjusted = difference.holm(np.array([effect.p for effect in found]))
    return tuple(replace(effect, p_adjusted=float(p)) for effect, p in zip(found, adjusted, strict=True))


def _strata(of: Array, one: Ints, other: Ints) -> Array:
    """Columns of pairs of algorithms, (p, a, ...) -> (problems and pairs, 2, ...)."""
    return np.stack([of[:, one], of[:, other]], axis=2).reshape(-1, 2, *of.shape[2:])


def _pairs(algorithms: Sequence[str]) -> Mapping[tuple[str, str, str], list[tuple[int, int]]]:
    """Pairs of algorithms that differ in one part only, that with it first, by stock, slot and operator."""
    found: dict[tuple[str, str, str], list[tuple[int, int]]] = {}
    keys = {key: i for i, name in enumerate(algorithms) if (key := _parted(name)) is not None}
    for (stock, parts), i in keys.items():
        for slot, operator in parts:
            without = keys.get((stock, parts - {(slot, operator)}))
            if without is not None:
                found.setdefault((stock, slot, operator), []).append((i, without))
    return found


def _parted(name: str) -> tuple[str, frozenset[tuple[str, str]]] | None:
    """The stock algorithm and its exchanged parts; None for a name given by the user."""
    try:
        spec = AlgorithmSpec.of(name)
    except UsageError:
        return None
    return spec.stock, frozenset((slot, one.text) for slot, one in spec.operators.items())
