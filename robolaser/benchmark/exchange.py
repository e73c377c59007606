"""What the exchange of one part does: an algorithm beside itself with other operators.

Runs with the part are compared with runs without it that are alike in all else: same problem, same other operators. The
effect is the mean of A12 over these strata (`mean_superiority`), the geometric mean of the ratios of running times
(`mean_ratios`), and the p of van Elteren's test of the strata.
"""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from robolaser.algorithms.exchanged import joined, parted
from robolaser.arrays import Array, Ints
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import HEADLINE
from robolaser.benchmark.standings.table import Measure
from robolaser.benchmark.statistics import running_time
from robolaser.benchmark.statistics.difference import holm, stratified
from robolaser.benchmark.statistics.outcome import outcomes
from robolaser.benchmark.statistics.superiority import mean_superiority, superiority
from robolaser.errors import UsageError

if TYPE_CHECKING:
    import pandas as pd

STOCK = ""
"""The level of a slot that keeps the stock algorithm's own operator."""


def study(stock: str, exchanges: Sequence[str], *, factorial: bool = False) -> list[str]:
    """The algorithms of a study, by name: the stock one, and what an exchange makes of it.

    Args:
        stock: An algorithm's name.
        exchanges: `slot=OPERATOR,OPERATOR...` each.
        factorial: Whether exchanges are combined in all ways; else one part is exchanged at a time.

    Raises:
        UsageError: An exchange is not of that form, or a slot comes twice.
    """
    levels: dict[str, list[str]] = {}
    for text in exchanges:
        slot, equals, operators = (piece.strip() for piece in text.partition("="))
        names = [name.strip() for name in operators.split(",")]
        if not equals or not all(names) or slot in levels or parted(f"{stock}+{slot}=x")[0] != stock:
            raise UsageError(
                f"--exchange {text}: expected a slot, which comes once, and its operators, as in"
                " crossover=ArithmeticCrossover,SBX. Slots are sampling, selection, crossover, mutation, survival and"
                " repair."
            )
        levels[slot] = [STOCK, *names]
    combined = product(*levels.values())
    chosen = [dict(zip(levels, each, strict=True)) for each in combined]
    return [joined(stock, parts) for parts in chosen if factorial or sum(map(bool, parts.values())) <= 1]


def effects(result: BenchmarkResult, family: str, measure: Measure = "evaluations", *, seed: int = 1) -> "pd.DataFrame":
    """What each exchanged part does, on all problems of a family.

    Args:
        result: Of algorithms that `study` names.
        family: Of problems.
        measure: What running times are counted in.
        seed: Of the bootstrap.

    Returns:
        A row for each part: `stock`, `slot`, `operator`; `strata`, the number of problems and pairs of algorithms that
        it rests on; `superiority`, how often a run with the part does better than one without, 0.5 being no effect;
        `ratio`, the running time with the part over that without at the headline target (below 1: faster); both with
        `_lower` and `_upper` of their 95 % interval, infinite where it is open; `p`, and `p_adjusted` by Holm for all
        rows. What is not known is missing.
    """
    import pandas as pd  # noqa: PLC0415 - a third of a second

    arrays = result.arrays(family)
    times, totals = arrays.measured(measure)
    headline = times[..., arrays.target(HEADLINE)]
    came = outcomes(headline, arrays.final)
    drawn = running_time.draws(len(arrays.problems), len(arrays.seeds), np.random.default_rng(seed))
    expected = running_time.expected(headline[..., None], totals)[..., 0]
    samples = running_time.resampled(headline[..., None], totals, drawn)[:, :, 0]
    rows = []
    for (stock, slot, operator), pairs in _pairs(arrays.algorithms).items():
        with_part, without = np.array(pairs).T
        strata = _strata(came, with_part, without)
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
        row = {"stock": stock, "slot": slot, "operator": operator, "strata": int(there.sum())}
        for name, bounds in (("superiority", better), ("ratio", ratio)):
            row |= {name: bounds.value[0, 1], f"{name}_lower": bounds.lower[0, 1], f"{name}_upper": bounds.upper[0, 1]}
        rows.append(row | {"p": stratified(strata[there])[0, 1]})
    frame = pd.DataFrame(rows)
    return frame.assign(p_adjusted=holm(frame.p.to_numpy())) if rows else frame


def _strata(of: Array, one: Ints, other: Ints) -> Array:
    """What two columns of algorithms have, (p, a, ...) -> (problems and pairs, 2, ...)."""
    paired: Array = np.stack([of[:, one], of[:, other]], axis=2)
    return paired.reshape(-1, 2, *of.shape[2:])


def _pairs(algorithms: Sequence[str]) -> Mapping[tuple[str, str, str], list[tuple[int, int]]]:
    """Which two algorithms differ in one part only, that with it first, by stock, slot and operator."""
    found: dict[tuple[str, str, str], list[tuple[int, int]]] = {}
    keys = {(stock, frozenset(parts.items())): i for i, (stock, parts) in enumerate(map(parted, algorithms))}
    for (stock, parts), i in keys.items():
        for slot, operator in parts:
            without = keys.get((stock, parts - {(slot, operator)}))
            if without is not None:
                found.setdefault((stock, slot, operator), []).append((i, without))
    return found
