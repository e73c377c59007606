"""How fast is the compiled chain: against plain NumPy, against the machine, and as it grows?

Every figure is the median of rounds in which all contestants take turns; in brackets the lowest and the highest.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"  # of the linear algebra; the kernel is told apart how many cores it may take
os.environ["ROBOLASER_COMPILE"] = "1"  # at once, for work of any size

import argparse
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from llvmlite.binding import get_host_cpu_features
from peak import CORES, FLOPS
from peer import Plain

from robolaser.arrays import Array
from robolaser.compiled import cores
from robolaser.data.dataset import Noise
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

POSES = {25: 5, 1000: 50, 20_000: 200}  # by number of points
AGAINST_PEER = ((100, 25), (100, 1000), (1000, 1000), (100, 20_000))
AGAINST_PEAK = ((100, 1000), (1000, 1000), (100, 20_000))
GROWTH = ((1, 10, 100, 1000, 10_000), (25, 1000, 20_000))  # candidates, points
MOST = 10_000_000  # point-evaluations of one call, beyond which growth is not followed
AGREES = 1e-9
BYTES_A_POINT = 5 * 8  # u, v and three coordinates of the target
SAMPLE_S = 0.03  # a sample lasts this long at least


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--rounds", type=int, default=7)
    rounds = options.parse_args().rounds
    robot = find_robot("scorbot_er7")
    models = {
        points: Model(simulate(robot, poses=poses, points=points // poses, noise=Noise(target_m=3e-4), seed=1).dataset)
        for points, poses in POSES.items()
    }
    against_peer(models, rounds)
    against_peak(models, rounds)
    growth(models, rounds)


def against_peer(models: dict[int, Model], rounds: int) -> None:
    print(
        "| cores | candidates × points | NumPy, einsum [ms] | NumPy, matmul [ms] | robolaser [ms] "
        "| million points a second | times einsum | times matmul | largest difference |"
    )
    print("|---" * 9 + "|")
    for threads in (1, CORES):
        use(threads)
        for c, m in AGAINST_PEER:
            model, plain, x = models[m], Plain.of(models[m].dataset), candidates(models[m], c)
            ways = plain.cost, plain.cost_by_matmul, model.cost
            difference = float(np.nanmax(np.abs(model.cost(x) / plain.cost(x) - 1)))
            assert difference < AGREES
            einsum, matmul, ours = np.array([[sample(way, x) for way in ways] for _ in range(rounds)]).T
            print(
                f"| {threads} | {c} × {m} | "
                + " | ".join(f"{1e3 * np.median(seconds):.3g}" for seconds in (einsum, matmul, ours))
                + f" | {c * m / np.median(ours) / 1e6:.0f} | {spread(einsum / ours)} | {spread(matmul / ours)} "
                f"| {difference:.0e} |",
                flush=True,
            )


def against_peak(models: dict[int, Model], rounds: int) -> None:
    for threads in (1, CORES):
        use(threads)
        measured: dict[tuple[int, int], list[float]] = {size: [] for size in AGAINST_PEAK}
        peaks, reading = [], []
        for _ in range(rounds):
            (narrow, read), (wide, _) = machine("+prefer-256-bit", threads), machine("-prefer-256-bit", threads)
            peaks.append(max(narrow, wide))
            reading.append(read)
            for c, m in AGAINST_PEAK:
                x = candidates(models[m], c)
                measured[c, m].append(c * m / sample(models[m].cost, x))
        peak = max(peaks)  # others may have used the machine meanwhile: the share is never flattered
        print(
            f"\nCores: {threads}. At most {peak / 1e6:.0f} million of the chain's mix of operations a second, "
            f"{peak * FLOPS / 1e9:.0f} Gflop/s; {max(reading) / 1e9:.0f} GB/s read from memory.\n"
        )
        print("| candidates × points | share of the peak | GB/s, were nothing in a cache | points' arrays [KB] |")
        print("|---|---|---|---|")
        for (c, m), rates in measured.items():
            rate = np.array(rates)
            print(
                f"| {c} × {m} | {spread(100 * rate / peak)} % | {np.median(rate) * BYTES_A_POINT / 1e9:.0f} "
                f"| {m * BYTES_A_POINT / 1e3:.0f} |",
                flush=True,
            )


def use(threads: int) -> None:
    """Let the kernel have so many cores."""
    os.environ["OMP_NUM_THREADS"] = str(threads)
    cores.cache_clear()


def growth(models: dict[int, Model], rounds: int) -> None:
    print("\nNanoseconds for one point of one candidate:\n")
    print("| candidates | " + " | ".join(f"{m} points" for m in GROWTH[1]) + " |")
    print("|---" * (1 + len(GROWTH[1])) + "|")
    for c in GROWTH[0]:
        cells = []
        for m in GROWTH[1]:
            if c * m > MOST:
                cells.append("")
                continue
            x = candidates(models[m], c)
            cells.append(f"{np.median([1e9 * sample(models[m].cost, x) / (c * m) for _ in range(rounds)]):.3g}")
        print(f"| {c} | " + " | ".join(cells) + " |", flush=True)


def candidates(model: Model, count: int) -> Array:
    """Anywhere within the bounds, (count, 14)."""
    bounds = model.parameters
    x: Array = np.random.default_rng(0).uniform(bounds.lower, bounds.upper, (count, len(bounds)))
    return x


def sample(cost: Callable[[Array], Array], x: Array) -> float:
    """Seconds of one call."""
    calls = 1
    while True:
        began = time.perf_counter()
        for _ in range(calls):
            cost(x)
        seconds = time.perf_counter() - began
        if seconds >= SAMPLE_S:
            return seconds / calls
        calls = max(2 * calls, round(calls * SAMPLE_S / max(seconds, 1e-9)))


def machine(feature: str, threads: int) -> tuple[float, float]:
    """Mixes a second and bytes a second, in a process of its own whose compiler prefers other vectors."""
    features = f"{get_host_cpu_features().flatten()},{feature}"
    script = Path(__file__).with_name("peak.py")
    done = subprocess.run(
        [sys.executable, script, str(threads)],
        env={**os.environ, "NUMBA_CPU_FEATURES": features},
        check=True,
        capture_output=True,
        text=True,
    )
    arithmetic, reading = map(float, done.stdout.split())
    return arithmetic, reading


def spread(values: Array) -> str:
    """Median, lowest and highest."""
    low, mid, high = (f"{value:.3g}" if value < 1000 else f"{value:.0f}" for value in np.quantile(values, (0, 0.5, 1)))
    return f"{mid} ({low} to {high})"


if __name__ == "__main__":
    main()
