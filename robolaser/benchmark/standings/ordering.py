"""Solvers in order, on one problem or on all of a family."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.standings import significance
from robolaser.benchmark.standings.answer import answer
from robolaser.benchmark.standings.estimates import UNKNOWN, estimate, plain, success
from robolaser.benchmark.standings.measurements import Measurements
from robolaser.benchmark.standings.table import Order, Pair, Ranks, Standing
from robolaser.benchmark.statistics import ecdf, mean_ranks, running_time, superiority
from robolaser.benchmark.statistics.difference import holm_pairs, stratified


def order(measured: Measurements, problems: Sequence[int], refused: Mapping[tuple[str, str], str]) -> Order:
    """Judge.

    Args:
        measured: Of the family.
        problems: Which of its problems count.
        refused: Why a solver does not apply to a problem, by (problem, solver).
    """
    names, at = measured.arrays.algorithms, list(problems)
    unranked = _unranked(measured, at, refused)
    ranked = [a for a, name in enumerate(names) if name not in unranked]
    blocks = mean_ranks.complete(measured.outcomes[at][:, ranked])
    if not len(blocks):
        unranked |= {names[a]: "no seed has a run of every algorithm" for a in ranked}
        ranked = []
    mean = {a: float(rank) for a, rank in zip(ranked, mean_ranks.mean_ranks(blocks), strict=bool(ranked))}
    standing = sorted(range(len(names)), key=lambda a: (a not in mean, mean.get(a, 0.0), names[a]))
    pairs = _pairs(measured, at, standing)
    areas = _areas(measured, at)
    places = tuple(
        Standing(
            algorithm=names[a],
            rank=1 + sum(other < mean[a] - 1e-9 for other in mean.values()) if a in mean else None,
            mean_rank=mean.get(a),
            runs=int(measured.runs[at, a].sum()),
            failed=int(measured.arrays.failed[at, a].sum()),
            success=success(measured.reached[at, a].sum(), measured.runs[at, a].sum()),
            running_time=estimate(measured.expected, (at[0], a, measured.headline)) if len(at) == 1 else UNKNOWN,
            solved=int((measured.reached[at, a] > 0).sum()),
            area=plain(areas[a]),
            against_first=pairs.get((standing[0], a)) if a in mean else None,
            unranked=unranked.get(names[a], ""),
        )
        for a in standing
    )
    return Order(
        measure=measured.measure,
        problems=tuple(measured.arrays.problems[p] for p in at),
        places=places,
        pairs=tuple(pairs.values()),
        ranks=_ranks([place for place in places if place.mean_rank is not None], len(blocks), pairs.values()),
        answer=answer(
            measured.measure,
            places,
            problems=len(at),
            runs=int(measured.runs[np.ix_(at, ranked)].min()) if ranked else 0,
            comparisons=_comparisons(measured, at),
        ),
    )


def _unranked(measured: Measurements, at: list[int], refused: Mapping[tuple[str, str], str]) -> dict[str, str]:
    """Who lacks so many runs that the others would have to be ranked on what little is left, and why."""
    arrays, found = measured.arrays, {}
    for a, name in enumerate(arrays.algorithms):
        for p in at:
            there, most = int(measured.runs[p, a]), int(measured.runs[p].max())
            if there < significance.ENOUGH * most or not most:
                problem = arrays.problems[p]
                found[name] = refused.get((problem, name), f"it has {there} of {len(arrays.seeds)} runs on {problem}")
                break
    return found


def _pairs(measured: Measurements, at: list[int], standing: list[int]) -> dict[tuple[int, int], Pair]:
    """Each with each, the one that stands before first."""
    arrays = measured.arrays
    solved = measured.reached[at] > 0
    both = solved[:, :, None] & solved[:, None, :]
    if len(at) == 1:
        better, ratio, p, adjusted = measured.superiority, measured.ratios, measured.p, measured.p_adjusted
        where: tuple[int, ...] = (at[0],)
    else:
        better = superiority.mean_superiority(superiority.superiority(measured.outcomes[at]))
        expected = measured.expected.value[..., measured.headline]
        ratio = running_time.mean_ratios(measured.samples[at], expected[at], measured.runs[at])
        p = stratified(measured.outcomes[at])
        adjusted, where = holm_pairs(p), ()
    found = {}
    for one, other in combinations(standing, 2):
        pair = (*where, one, other)
        superior = estimate(better, pair)
        found[one, other] = Pair(
            one=arrays.algorithms[one],
            other=arrays.algorithms[other],
            superiority=superior,
            effect=None if superior.value is None else significance.effect(superior.value),
            ratio=estimate(ratio, pair) if both[:, one, other].any() else UNKNOWN,
            ratio_problems=tuple(arrays.problems[at[i]] for i in np.flatnonzero(both[:, one, other])),
            p=plain(p[pair]),
            p_adjusted=plain(adjusted[pair]),
            significant=significance.is_significant(float(adjusted[pair])),
        )
    return found


def _comparisons(measured: Measurements, at: list[int]) -> int:
    """For which the p of these problems are corrected."""
    if len(at) == 1:
        return int((~np.isnan(measured.p)).sum()) // 2
    has = measured.runs[at] > 0
    both = (has[:, :, None] & has[:, None, :]).any(axis=0)
    return int(np.triu(both, 1).sum())


def _areas(measured: Measurements, at: list[int]) -> Array:
    running_times = measured.running_times[at]
    budgets = ecdf.budgets(running_times, measured.totals[at], points=2)
    if not len(budgets) or budgets[-1] <= budgets[0]:
        return np.full(running_times.shape[1], np.nan)
    return ecdf.areas(running_times, float(budgets[0]), float(budgets[-1]))


def _ranks(places: Sequence[Standing], blocks: int, pairs: Iterable[Pair]) -> Ranks:
    names = [place.algorithm for place in places]
    differ = {frozenset((pair.one, pair.other)) for pair in pairs if pair.significant}
    alike = np.array([[frozenset((one, other)) not in differ for other in names] for one in names], bool)
    return Ranks(
        algorithms=tuple(names),
        mean_ranks=tuple(place.mean_rank for place in places if place.mean_rank is not None),
        blocks=blocks,
        groups=tuple(tuple(names[i] for i in group) for group in mean_ranks.groups(alike)),
    )
