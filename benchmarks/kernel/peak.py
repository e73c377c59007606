"""What this machine's cores can do at most: arithmetic in the chain's own mix, and reading from memory.

The least arithmetic that one point of one candidate needs, with all that depends on the candidate alone or on the point
alone worked out before (target points and their poses are put into the flange frame once):

    step                                            fma  mul  add  div
    ũ, ṽ: pixel to metric, s u + c                    2
    r² = ũ² + ṽ²                                      1    1
    1 + k r²                                          1
    u, v: times that                                       2
    v + f tan θ                                                 1
    ρ = b / that                                                     1
    R (v, −u, f), its last column times f before      6
    E = (d − t) − ρ times that                        3         3
    E², summed                                        3
                                                     16    3    4    1

The loop below does this mix on values that do not wait for each other and lie in the first cache.
"""

import os
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numba
import numpy as np

from robolaser.arrays import Array

LANES = 512  # five arrays of these fill 20 KB
ROUNDS = 4000
MEMORY_BYTES = 1 << 30  # beyond any cache
ATTEMPTS = 5  # the quickest counts; the first compiles
FLOPS = 16 * 2 + 3 + 4 + 1
CORES = os.cpu_count() or 1


@numba.njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"})
def mix(a: Array, b: Array, c: Array, d: Array, e: Array, p: float, q: float, rounds: int) -> None:
    for _ in range(rounds):
        for i in range(len(a)):
            h, j, k, m = a[i], b[i], c[i], d[i]
            h = (((h * p + q) * p + q) * p + q) * p + q
            j = (((j * p + q) * p + q) * p + q) * p + q
            k = ((((k * p + q) * p + q) * p + q) * p + q) * p * p * p
            m = ((((m * p + q) * p + q) * p + q) * p + q) + q + q + q + q
            a[i], b[i], c[i], d[i] = h, j, k, m
            e[i] = q / e[i]


@numba.njit(nogil=True, cache=True, fastmath=True)
def total(values: Array) -> float:
    s = 0.0
    for i in range(len(values)):
        s += values[i]
    return s


def arithmetic_rate(threads: int) -> float:
    """Mixes a second, on so many cores together [1/s]."""
    lanes = [[np.full(LANES, 0.5) for _ in range(5)] for _ in range(threads)]
    seconds = _at_once([lambda part=part: mix(*part, 0.5, 0.25, ROUNDS) for part in lanes])
    return threads * LANES * ROUNDS / seconds


def reading_rate(threads: int) -> float:
    """Bytes a second read from memory by so many cores together [B/s]."""
    parts = np.array_split(np.ones(MEMORY_BYTES // 8), threads)
    return MEMORY_BYTES / _at_once([lambda part=part: total(part) for part in parts])


def _at_once(works: list[Callable[[], object]]) -> float:
    with ThreadPoolExecutor(len(works)) as pool:
        best = np.inf
        for _ in range(ATTEMPTS):
            began = time.perf_counter()
            list(pool.map(lambda work: work(), works))
            best = min(best, time.perf_counter() - began)
    return best


if __name__ == "__main__":
    threads = int(sys.argv[1])
    print(arithmetic_rate(threads), reading_rate(threads))
