"""Gross errors in a few rows: a reflection taken for the stripe, a reflector mixed up, a ball not seated."""

from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.errors import UsageError
from robolaser.model.effects.outliers import NAME, WHERE

MOST = 0.5  # of the rows: beyond, the gross ones are the rule
STRAY_PX = (10.0, 60.0)  # across the stripe
STRAY_M = (5e-3, 5e-2)
STRAY_RAD = (0.01, 0.05)  # of one joint in an unseated pose [rad or m]


def share_of(sizes: dict[str, float]) -> float:
    """Take the share of gross errors out of the effects asked for; 0 where there is none.

    Raises:
        UsageError: It is no share, or more than half.
    """
    share = sizes.pop(f"{NAME}:{WHERE}", 0.0) or sizes.pop(NAME, 0.0)
    if not 0 <= share <= MOST:
        raise impossible(f"share of {NAME}", share, f"a number from 0 to {MOST:g}")
    return share


def impossible(what: str, value: object, expected: str) -> UsageError:
    """A simulated cell cannot have this."""
    return UsageError(f"A cell cannot be simulated with {what} {value!r}: expected {expected}.")


def spoil(dataset: Dataset, share: float, rng: np.random.Generator) -> tuple[Dataset, Ints]:
    """Put gross errors into a share of the rows, one at least.

    Returns:
        The data set, and the rows that are spoilt.
    """
    points = dataset.points
    if not share:
        return dataset, np.empty(0, dtype=np.int64)
    rows = np.sort(rng.choice(len(points), size=max(1, round(share * len(points))), replace=False))
    sign = rng.choice([-1.0, 1.0], size=len(rows))
    if points.pixel is not None and dataset.image_px is not None:
        across = 1 if dataset.stripe_axis == "u" else 0
        moved = points.pixel.copy()
        size = dataset.image_px[across] - 1.0
        moved[rows, across] = _strayed(moved[rows, across], sign * rng.uniform(*STRAY_PX, len(rows)), 0.0, size)
        return replace(dataset, points=replace(points, pixel=moved)), rows
    if points.xyz is not None:
        way = rng.normal(size=(len(rows), 3))
        far = rng.uniform(*STRAY_M, (len(rows), 1))
        xyz = points.xyz.copy()
        xyz[rows] += far * way / np.linalg.norm(way, axis=1, keepdims=True)
        return replace(dataset, points=replace(points, xyz=xyz)), rows
    (robot, read), pose = dataset.arm, points.pose[rows]
    q = read.copy()
    joint = np.array(robot.chain)[rng.integers(len(robot.chain), size=len(rows))]
    lower, upper = robot.lower[joint], robot.upper[joint]
    q[pose, joint] = _strayed(q[pose, joint], sign * rng.uniform(*STRAY_RAD, len(rows)), lower, upper)
    return replace(dataset, poses=replace(dataset.poses, q=q)), rows


def _strayed(value: Array, by: Array, lower: Array | float, upper: Array | float) -> Array:
    """Stray the other way where this one leads out of bounds."""
    there = value + by
    return np.where((there < lower) | (there > upper), value - by, there)
