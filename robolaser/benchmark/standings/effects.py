"""What the exchange of one part does.

Runs with the part are compared with runs without it that are alike in all else: same problem, same other operators. The
effect is the mean of A12 over these strata (`mean_superiority`), the geometric mean of the ratios of running times
(`mean_ratios`), and the p of van Elteren's test of the strata.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from robolaser.algorithms.spec import AlgorithmSpec
from robolaser.arrays import Array, Ints
from robolaser.benchmark.standings.table import PartEffect
from robolaser.benchmark.statistics import running_time
from robolaser.benchmark.statistics.difference import holm, stratified
from robolaser.benchmark.statistics.superiority import mean_superiority, superiority
from robolaser.errors import UsageError


def effects(algorithms: Sequence[str], places: Array, expected: Array, samples: Array) -> tuple[PartEffect, ...]:
    """The effect of each part that is exchanged in one of the algorithms and in another is not.

    Places of runs (p, a, s), expected running times to the headline target (p, a), the same in bootstrap samples (p, a,
    b).
    """
    found = []
    for (stock, slot, operator), pairs in _pairs(algorithms).items():
        with_part, without = np.array(pairs).T
        strata = _strata(places, with_part, without)
        runs = (~np.isnan(strata)).sum(axis=2)
        there = (runs > 0).all(axis=1)
        if not there.any():
            continue
        better = mean_superiority(superiority(strata[there]))
        ratio = running_time.mean_ratios(
            _strata(samples, without, with_part)[there],
            _strata(expected, without, with_part)[there],
            runs[there][:, ::-1],
        )
        p = float(stratified(strata[there])[0, 1])
        found.append(
            PartEffect(stock, slot, operator, int(there.sum()), better.at(0, 1), ratio.at(0, 1), p, p_adjusted=p)
        )
    adjusted = holm(np.array([effect.p for effect in found]))
    return tuple(replace(effect, p_adjusted=float(p)) for effect, p in zip(found, adjusted, strict=True))


def _strata(of: Array, one: Ints, other: Ints) -> Array:
    """What two columns of algorithms have, (p, a, ...) -> (problems and pairs, 2, ...)."""
    paired: Array = np.stack([of[:, one], of[:, other]], axis=2)
    return paired.reshape(-1, 2, *of.shape[2:])


def _pairs(algorithms: Sequence[str]) -> Mapping[tuple[str, str, str], list[tuple[int, int]]]:
    """Which two algorithms differ in one part only, that with it first, by stock, slot and operator."""
    found: dict[tuple[str, str, str], list[tuple[int, int]]] = {}
    keys = {key: i for i, name in enumerate(algorithms) if (key := _parted(name)) is not None}
    for (stock, parts), i in keys.items():
        for slot, operator in parts:
            without = keys.get((stock, parts - {(slot, operator)}))
            if without is not None:
                found.setdefault((stock, slot, operator), []).append((i, without))
    return found


def _parted(name: str) -> tuple[str, frozenset[tuple[str, str]]] | None:
    """The stock algorithm and its exchanged parts; None of a name that somebody gave."""
    try:
        spec = AlgorithmSpec.of(name)
    except UsageError:
        return None
    return spec.stock, frozenset((slot, one.text) for slot, one in spec.operators.items())
