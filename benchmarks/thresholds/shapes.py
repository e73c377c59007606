"""Simulate what chance gains by the choice of an effect's shape: a frequency, a time constant, a moment.

    python benchmarks/thresholds/shapes.py

An effect with nonlinear parameters is tried with each value of a grid, and the best is kept. On data that hold nothing
but noise the largest of those gains exceeds a level more often than chi-squared does. The price of the choice is the
distance between the two levels that are exceeded with the same probability. To first order it is twice the logarithm
of the number of shapes that are independent.
"""

import argparse
import os
from collections import defaultdict

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from robolaser import EFFECTS, find_robot
from robolaser.arrays import Array
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.score_tests import Columns, library
from robolaser.simulation import simulate

LEVELS = (1e-2, 1e-3)
NOISE = Noise(pixel_px=0.1, target_m=3e-5, point_m=2e-5)


def prices(bases: list[Array], draws: int, rng: np.random.Generator) -> list[float]:
    """Distance in chi-squared between the levels of the largest gain and of one shape's, at each of `LEVELS`.

    Args:
        bases: Orthonormal columns of each shape, (K, a).
        draws: Number of data sets of nothing but noise.
        rng: Where they come from.
    """
    U, s, _ = np.linalg.svd(np.hstack(bases), full_matrices=False)
    space = U[:, s > 1e-6 * s[0]]
    z = rng.standard_normal((space.shape[1], draws))
    largest = np.zeros(draws)
    for basis in bases:
        np.maximum(largest, np.square((basis.T @ space) @ z).sum(axis=0), out=largest)
    one = np.square(rng.standard_normal((bases[0].shape[1], 50 * draws))).sum(axis=0)
    return [float(np.quantile(largest, 1 - level) - np.quantile(one, 1 - level)) for level in LEVELS]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", default="scorbot_er7,ur5,panda")
    parser.add_argument("--sensors", default="stripe,point")
    parser.add_argument("--poses", type=int, default=50)
    parser.add_argument("--draws", type=int, default=20_000)
    args = parser.parse_args()
    found = defaultdict(list)
    for sensor in args.sensors.split(","):
        for robot in args.robots.split(","):
            dataset = simulate(find_robot(robot), kind=sensor, poses=args.poses, noise=NOISE, seed=1).dataset
            effects = library(EFFECTS, dataset)
            fit = Preparation.of(dataset, 1).fit(effects)
            columns, rng = Columns(), np.random.default_rng(1)
            for one in effects:
                grid = one.effect.grid(dataset, one.where)
                if len(grid) < 2:
                    continue
                left = fit.at.project(columns.by_effect(fit, one, grid))
                shapes = np.split(left, len(grid), axis=1)
                bases = [np.linalg.qr(some)[0] for some in shapes if np.linalg.matrix_rank(some) == some.shape[1]]
                if len(bases) > 1:
                    found[one.effect.name].append((len(bases), *prices(bases, args.draws, rng)))
    print(f"{'effect':20} {'places':>6} {'tried':>6} {'at 0.01':>8} {'at 0.001':>9} {'most':>6} {'independent':>12}")
    for name, rows in found.items():
        tried, at_2, at_3 = (float(np.median(column)) for column in np.array(rows).T)
        most = max(row[2] for row in rows)
        share = min(1.0, np.exp(most / 2.0) / tried)
        print(f"{name:20} {len(rows):6d} {tried:6.0f} {at_2:8.1f} {at_3:9.1f} {most:6.1f} {share:12.2f}")


if __name__ == "__main__":
    main()
