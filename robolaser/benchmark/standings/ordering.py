"""Contestants in order, on one problem or on all of a family."""

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.standings import judge
from robolaser.benchmark.standings.answer import answer
from robolaser.benchmark.standings.estimates import UNKNOWN, estimate, plain, success
from robolaser.benchmark.standings.evidence import Evidence
from robolaser.benchmark.standings.table import Order, Pair, Place, Ranks
from robolaser.benchmark.statistics import ecdf, mean_ranks, running_time, superiority
from robolaser.benchmark.statistics.difference import holm_pairs, stratified


def order(evidence: Evidence, problems: Sequence[int], refused: Mapping[tuple[str, str], str]) -> Order:
    """Judge.

    Args:
        evidence: Of the family.
        problems: Which of its problems count.
        refused: Why a contestant has nothing to say on a problem, by (problem, contestant).
    """
    names, at = evidence.tally.algorithms, list(problems)
    unranked = _unranked(evidence, at, refused)
    ranked = [a for a, name in enumerate(names) if name not in unranked]
    ranks = mean_ranks.mean_ranks(mean_ranks.complete(evidence.outcomes[at][:, ranked]))
    if not ranks.blocks:
        unranked |= {names[a]: "there is no seed with a run of everybody" for a in ranked}
        ranked = []
    mean = {a: float(rank) for a, rank in zip(ranked, ranks.mean, strict=bool(ranked))}
    standing = sorted(range(len(names)), key=lambda a: (a not in mean, mean.get(a, 0.0), names[a]))
    pairs = _pairs(evidence, at, standing)
    areas = _areas(evidence, at)
    places = tuple(
        Place(
            algorithm=names[a],
            rank=1 + sum(other < mean[a] - 1e-9 for other in mean.values()) if a in mean else None,
            mean_rank=mean.get(a),
            runs=int(evidence.runs[at, a].sum()),
            failed=int(evidence.tally.failed[at, a].sum()),
            success=success(evidence.reached[at, a].sum(), evidence.runs[at, a].sum()),
            price=estimate(evidence.expected, (at[0], a, evidence.headline)) if len(at) == 1 else UNKNOWN,
            solved=int((evidence.reached[at, a] > 0).sum()),
            area=plain(areas[a]),
            against_first=pairs.get((standing[0], a)) if a in mean else None,
            unranked=unranked.get(names[a], ""),
        )
        for a in standing
    )
    return Order(
        measure=evidence.measure,
        problems=tuple(evidence.tally.problems[p] for p in at),
        places=places,
        pairs=tuple(pairs.values()),
        ranks=_ranks(ranks, [names[a] for a in ranked]),
        answer=answer(
            evidence.measure,
            places,
            problems=len(at),
            runs=int(evidence.runs[np.ix_(at, ranked)].min()) if ranked else 0,
            comparisons=_comparisons(evidence, at),
        ),
    )


def _unranked(evidence: Evidence, at: list[int], refused: Mapping[tuple[str, str], str]) -> dict[str, str]:
    """Who lacks so many runs that the others would have to be ranked on what little is left, and why."""
    tally, found = evidence.tally, {}
    for a, name in enumerate(tally.algorithms):
        for p in at:
            there, most = int(evidence.runs[p, a]), int(evidence.runs[p].max())
            if there < judge.ENOUGH * most or not most:
                problem = tally.problems[p]
                found[name] = refused.get((problem, name), f"it has {there} of {len(tally.seeds)} runs on {problem}")
                break
    return found


def _pairs(evidence: Evidence, at: list[int], standing: list[int]) -> dict[tuple[int, int], Pair]:
    """Each with each, the one that stands before first."""
    tally = evidence.tally
    solved = evidence.reached[at] > 0
    both = solved[:, :, None] & solved[:, None, :]
    if len(at) == 1:
        better, ratio, p, adjusted = evidence.superiority, evidence.ratios, evidence.p, evidence.p_adjusted
        where: tuple[int, ...] = (at[0],)
    else:
        better = superiority.mean_superiority(superiority.superiority(evidence.outcomes[at]))
        expected = evidence.expected.value[..., evidence.headline]
        ratio = running_time.mean_ratios(evidence.samples[at], expected[at], evidence.runs[at])
        p = stratified(evidence.outcomes[at])
        adjusted, where = holm_pairs(p), ()
    found = {}
    for one, other in combinations(standing, 2):
        pair = (*where, one, other)
        superior = estimate(better, pair)
        found[one, other] = Pair(
            one=tally.algorithms[one],
            other=tally.algorithms[other],
            superiority=superior,
            effect=None if superior.value is None else judge.effect(superior.value),
            ratio=estimate(ratio, pair) if both[:, one, other].any() else UNKNOWN,
            ratio_problems=tuple(tally.problems[at[i]] for i in np.flatnonzero(both[:, one, other])),
            p=plain(p[pair]),
            p_adjusted=plain(adjusted[pair]),
            told=judge.told(float(adjusted[pair])),
        )
    return found


def _comparisons(evidence: Evidence, at: list[int]) -> int:
    """For which the p of these problems are corrected."""
    if len(at) == 1:
        return int((~np.isnan(evidence.p)).sum()) // 2
    has = evidence.runs[at] > 0
    both = (has[:, :, None] & has[:, None, :]).any(axis=0)
    return int(np.triu(both, 1).sum())


def _areas(evidence: Evidence, at: list[int]) -> Array:
    prices = evidence.prices[at]
    budgets = ecdf.budgets(prices, evidence.spent[at], points=2)
    if not len(budgets) or budgets[-1] <= budgets[0]:
        return np.full(prices.shape[1], np.nan)
    return ecdf.areas(prices, float(budgets[0]), float(budgets[-1]))


def _ranks(ranks: mean_ranks.MeanRanks, names: list[str]) -> Ranks:
    if not names:
        return Ranks((), (), 0, None, None, None, (), ())
    by_rank = sorted(range(len(names)), key=lambda a: (ranks.mean[a], names[a]))
    difference = plain(ranks.critical_difference)
    return Ranks(
        algorithms=tuple(names[a] for a in by_rank),
        mean_ranks=tuple(float(ranks.mean[a]) for a in by_rank),
        blocks=ranks.blocks,
        statistic=plain(ranks.statistic),
        p=plain(ranks.p),
        critical_difference=difference,
        nemenyi=()
        if difference is None
        else tuple(tuple(map(float, row)) for row in ranks.nemenyi[np.ix_(by_rank, by_rank)]),
        groups=tuple(
            tuple(names[by_rank[i]] for i in group)
            for group in mean_ranks.groups(ranks.mean[by_rank], ranks.critical_difference)
        ),
    )
