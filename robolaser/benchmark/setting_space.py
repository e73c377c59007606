"""Which settings of an algorithm to try: combinations of some values, samples of ranges, and what is near the best."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import Any, final

import numpy as np

from robolaser.algorithms.exchanged import joined, parted
from robolaser.algorithms.settings import Value, read
from robolaser.arrays import Array
from robolaser.errors import UsageError

SAMPLES = 20
"""Settings to begin with, where there are ranges."""
DECADE = 10.0
"""Ranges whose ends are so many times apart are sampled on a logarithmic scale."""
CROWDED = 10
"""Samples for each one wanted after which there is nothing new."""


@final
class SettingSpace:
    """Settings of an algorithm, each from a range or a list; the values of a list stand in order.

    Args:
        algorithm: Its name, with what is set for good.
        texts: `KEY=A,B,C` or `KEY=LOW..HIGH` each; a range of whole numbers gives whole numbers.
        samples: Settings to begin with; by default all combinations where there are no ranges, else `SAMPLES`.
        seed: Of the samples.

    Raises:
        UsageError: A text is not of that form, or a setting comes twice.
    """

    def __init__(self, algorithm: str, texts: Sequence[str], *, samples: int | None = None, seed: int = 1) -> None:
        self._algorithm, self._rng = algorithm, np.random.default_rng(seed)
        self._varied: dict[str, tuple[Any, ...]] = {}
        self._ranges: set[str] = set()
        for text in texts:
            key, equals, values = (piece.strip() for piece in text.partition("="))
            listed: list[Any] = [read(value.strip()) for value in values.split(",")]
            ends: list[Any] = [read(end) for end in values.split("..")]
            if len(ends) == 2 and all(map(_is_number, ends)) and ends[0] < ends[1]:
                self._ranges.add(key)
                listed = ends
            elif not equals or "" in listed or ".." in values:
                listed = []
            if not key or not listed or key in self._varied:
                raise UsageError(
                    f"--vary {text}: expected a setting, which comes once, and its values or its range, as in"
                    " pop_size=20,50,100 or b=0.5..8."
                )
            self._varied[key] = tuple(listed)
        grid = samples is None and not self._ranges
        self.samples = math.prod(len(values) for values in self._varied.values()) if grid else samples or SAMPLES
        self._at: dict[str, Array] = {}
        cells = [(np.arange(len(values)) + 0.5) / len(values) for values in self._varied.values()]
        settings = self._new(map(np.array, product(*cells))) if grid else self._sampled(self.samples)
        self.first: tuple[str, ...] = (algorithm, *settings)

    @property
    def rounds(self) -> int:
        """How often a race samples anew, as in irace: 2 + log2 of the number of ranges; once where there are none."""
        return 2 + int(math.log2(len(self._ranges))) if self._ranges else 1

    def near(self, best: Sequence[str], count: int, number: int) -> tuple[str, ...]:
        """So many new settings near the best, nearer in later rounds (from 1): irace's truncated normal."""
        parents = [self._at[name] for name in best if name in self._at]
        spread = 0.5 * max(count, 2) ** (-number / len(self._varied))
        return self._sampled(count, parents, spread)

    def _sampled(self, count: int, parents: Sequence[Array] = (), spread: float = 0.0) -> tuple[str, ...]:
        def places() -> Iterator[Array]:
            for _ in range(CROWDED * count):
                at = self._rng.uniform(size=len(self._varied))
                if len(parents):
                    near = parents[int(self._rng.integers(len(parents)))] + spread * self._rng.normal(size=len(at))
                    at = np.where((near >= 0) & (near < 1), near, at)
                yield at

        return self._new(places(), count)

    def _new(self, places: Iterable[Array], count: int | None = None) -> tuple[str, ...]:
        """The algorithm with the settings at so many places of the unit box, as far as they were not there before."""
        stock, parts = parted(self._algorithm)
        found: list[str] = []
        for at in places:
            name = joined("".join([stock, *map(self._setting, self._varied, at)]), parts)
            if name not in self._at:
                self._at[name] = at
                found.append(name)
            if len(found) == count:
                break
        return tuple(found)

    def _setting(self, key: str, at: float) -> str:
        values = self._varied[key]
        if key not in self._ranges:
            return f":{key}={values[int(at * len(values))]}"
        low, high = values
        is_log, is_whole = low > 0 and high / low >= DECADE, all(isinstance(end, int) for end in values)
        if is_whole:
            low, high = low - 0.5, high + 0.499
        value = low * (high / low) ** at if is_log else low + at * (high - low)
        return f":{key}={round(value) if is_whole else f'{value:.3g}'}"


def _is_number(value: Value) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
