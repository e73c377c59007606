"""Stripe alone against stripe and corners in one fit, held out, on the ETNA sessions.

python benchmarks/two_stage/corners.py DATA
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from robolaser import load
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.vision.recordings import points_from_images

SEEDS = {"etna-s1": (1,), "etna-s2": (1,), "etna-s3": (1, 2, 3)}  # single poses are held out where there are few
DRAWS = 4000


def squares(dataset, weights, seed):
    """Squared held-out errors of the stripe's rows, summed over each pose, and how many rows there are."""
    found = calibrate(dataset, Plan(weights=weights, effects=("laser_roll",), seed=seed))
    rows, *_ = next(iter(found.model.blocks.kinds_of_rows.values()))
    return np.bincount(dataset.points.pose[rows], (found.held_out[rows] ** 2).sum(axis=1)), len(rows)


def main(data):
    for name, seeds in SEEDS.items():
        both = points_from_images(load(data / name))[1]
        variants = {
            "stripe": replace(both.sensors[0].data, parameters=both.parameters),
            "stripe and corners": both,
            "stripe and corners, nothing given": replace(both, parameters={}),
        }
        for weights in ("plain", "noise"):
            for seed in seeds:
                alone = None
                for variant, dataset in variants.items():
                    of_pose, rows = squares(dataset, weights, seed)
                    alone = of_pose if alone is None else alone
                    drawn = np.random.default_rng(0).integers(len(of_pose), size=(DRAWS, len(of_pose)))
                    ratio = np.sqrt(of_pose[drawn].sum(axis=1) / alone[drawn].sum(axis=1))
                    low, high = np.quantile(ratio, [0.05, 0.95])
                    print(name, weights, seed, variant, f"{1e3 * np.sqrt(of_pose.sum() / rows):.4f} mm", end=" ")
                    print(f"ratio {low:.3f} to {high:.3f}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
