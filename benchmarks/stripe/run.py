"""Speed and accuracy of line centres compared with NumPy, SciPy and the Cramér-Rao bound.

Speed is CPU time on one core, from the image in memory to the selected centres. Values are medians of rounds in which
all programs take turns, with the lowest and the highest in brackets.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

import argparse
import time
from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
from peer import centre_of_mass, curve_fitted

from robolaser.arrays import Array, Image
from robolaser.data.stripe_file import Stripes
from robolaser.vision.images import laser_alone
from robolaser.vision.stripe_trace import trace

HEIGHT, WIDTH = 480, 640
NOISE = 2.0
COURSE = 318.3 + 0.0411 * np.arange(HEIGHT)
BREADTHS, HEIGHTS = (1.5, 2.0, 3.0), (120.0, 150.0, 180.0)
SEEDS = 4


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--rounds", type=int, default=9)
    cv2.setNumThreads(1)
    speed(options.parse_args().rounds)
    exactness()
    saturation()


def speed(rounds: int) -> None:
    dark = drawn(20 + 0 * stripe(2, 1), NOISE, 9)
    images = {
        "ordinary": (drawn(20 + stripe(2, 150), NOISE, 1), None),
        "saturated": (drawn(20 + stripe(4, 900), NOISE, 1), None),
        "ordinary, laser on and off": (drawn(20 + stripe(2, 150), NOISE, 1), dark),
    }
    print("| image, 640 × 480 | gauss [frames/s] | NumPy [frames/s] ", end="")
    print("| SciPy, line by line [frames/s] | gauss times NumPy | gauss times SciPy |")
    print("|---" * 6 + "|")
    for name, (image, off) in images.items():
        ways = [partial(traced, image, off), partial(centre_of_mass, image), partial(curve_fitted, image)]
        for way in ways:
            way()
        seconds = np.array([[sample(way) for way in ways] for _ in range(rounds)])
        cells = [spread(1 / column) for column in seconds.T]
        gauss, numpy, scipy = seconds.T
        print(f"| {name} | {' | '.join(cells)} | {spread(numpy / gauss)} | {spread(scipy / gauss)} |")


def traced(image: Image, off: Image | None) -> Stripes:
    return trace(image if off is None else laser_alone(image, off), "v")


def exactness() -> None:
    print(
        "\n| width σ [px] | height [grey] | bound [px] | "
        + " | ".join(f"{n}: noise/bound, worst bias [px]" for n in named())
        + " |"
    )
    print("|---" * (3 + len(named())) + "|")
    for breadth in BREADTHS:
        for height in HEIGHTS:
            bound = np.hypot(NOISE, 12**-0.5) / height * np.sqrt(2 * breadth / np.sqrt(np.pi))
            cells = []
            for way in named().values():
                error = np.stack(
                    [way(drawn(20 + stripe(breadth, height), NOISE, seed)) - COURSE for seed in range(SEEDS)]
                )
                still = way(drawn(20 + stripe(breadth, height), 0.0, 0)) - COURSE
                cells.append(f"{np.nanstd(error) / bound:.2f}, {worst_bias(still):.3f}")
            print(f"| {breadth} | {height:.0f} | {bound:.4f} | {' | '.join(cells)} |", flush=True)


def saturation() -> None:
    print(
        "\n| width σ [px] | height, clipped at 255 [grey] | "
        + " | ".join(f"{n}: RMS, mean [px]" for n in named())
        + " |"
    )
    print("|---" * (2 + len(named())) + "|")
    for breadth, height in ((2.0, 300.0), (2.0, 600.0), (3.0, 1500.0), (5.0, 3000.0)):
        cells = []
        for way in named().values():
            error = np.stack([way(drawn(20 + stripe(breadth, height), NOISE, seed)) - COURSE for seed in range(SEEDS)])
            cells.append(f"{np.sqrt(np.nanmean(error**2)):.3f}, {np.nanmean(error):+.3f}")
        print(f"| {breadth} | {height:.0f} | {' | '.join(cells)} |", flush=True)


def named() -> dict[str, Callable[[Image], Array]]:
    """The programs, as functions from an image to one line centre a row, NaN for none."""
    return {"gauss": in_rows, "NumPy": centre_of_mass, "SciPy": curve_fitted}


def in_rows(image: Image) -> Array:
    rows = np.full(HEIGHT, np.nan)
    found = trace(image, "v")
    rows[np.rint(found["v"]).astype(int)] = found["u"]
    return rows


def worst_bias(error: Array) -> float:
    """Largest mean error at any of eight subpixel positions [px]."""
    phase, there = np.floor(8 * (COURSE % 1)).astype(int), np.isfinite(error)
    return max(abs(float(error[there & (phase == k)].mean())) for k in range(8))


def stripe(breadth: float, height: float) -> Array:
    """A Gaussian profile integrated over the pixels' areas, (HEIGHT, WIDTH) [grey]."""
    at = (np.arange(8 * WIDTH) + 0.5) / 8 - 0.5
    fine = height * np.exp(-0.5 * ((at - COURSE[:, None]) / breadth) ** 2)
    return np.asarray(fine.reshape(HEIGHT, WIDTH, 8).mean(axis=-1))


def drawn(light: Array, noise: float, seed: int) -> Image:
    light = light + noise * np.random.default_rng(seed).standard_normal(light.shape)
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def sample(way: Callable[[], object]) -> float:
    """CPU seconds of one call."""
    calls = 1
    while True:
        began = time.process_time()
        for _ in range(calls):
            way()
        seconds = time.process_time() - began
        if seconds >= 0.05:
            return seconds / calls
        calls *= 2


def spread(values: Array) -> str:
    """Median, lowest and highest."""
    low, mid, high = (f"{value:.3g}" if value < 1000 else f"{value:.0f}" for value in np.quantile(values, (0, 0.5, 1)))
    return f"{mid} ({low} to {high})"


if __name__ == "__main__":
    main()
