"""Rows that no model explains: gross errors, whole poses in error, a point that moved."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Ints
from robolaser.calibration.contradicted_distance import ContradictedDistance
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.cause_words import NAMED, listed
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.noise_remarks import over_stated
from robolaser.diagnosis.thresholds import CREDIBLE_MASS, MOST_OVER_STATED, NO_NOISE
from robolaser.estimation.certainty import EVEN, LIKELY
from robolaser.model.noise.covariance import NoiseModel


def outlying_poses(dataset: Dataset, rows: Ints) -> tuple[str, ...]:
    """Names of poses with several points, all among some rows of points.csv: the arm may have been elsewhere."""
    of_pose, count = dataset.points.pose, len(dataset.poses)
    every, out = np.bincount(of_pose, minlength=count), np.bincount(of_pose[rows], minlength=count)
    return tuple(dataset.poses.names[i] for i in np.flatnonzero((every > 1) & (out == every)))


def probability(dataset: Dataset, rows: Ints, verdict: str) -> float:
    """Probability that outlying rows are gross errors.

    Whole poses may show a cause that no effect describes, and so may single rows if a gap is unexplained.
    """
    return LIKELY if verdict == "unexplained" or _are_whole(dataset, rows) else 1.0


def rows_sentence(final: Fit, noise: NoiseModel, verdict: str, dataset: Dataset, outliers: Ints) -> str:
    """A sentence on rows, and known distances, that disagree with the others; may be empty."""
    scatter = ""
    if verdict == "unexplained":
        scatter = _uneven(final) or _beyond_stated(noise)
    off = ContradictedDistance.of(final.model, final.x)
    return scatter + (f" {off.clause}: measure it again." if off else "") + gross_sentence(dataset, outliers)


def gross_sentence(dataset: Dataset, rows: Ints) -> str:
    """A sentence on gross errors; may be empty."""
    if not len(rows):
        return ""
    if _are_whole(dataset, rows):
        poses = outlying_poses(dataset, rows)
        whose, are, they = ("pose", "it is", "it shows") if len(poses) == 1 else ("poses", "they are", "they show")
        return (
            f" All points of {whose} {shortened(poses)} are off together, and excluded: either {are} wrong, or a cause"
            f" that only {they} is present."
        )
    return f" {counted(dataset, rows)}, listed and excluded."


def counted(dataset: Dataset, rows: Ints) -> str:
    """How many rows of which files are gross errors."""
    files = listed([one.file for one in dataset.sensors if np.isin(one.rows, rows).any()])
    return f"{len(rows)} rows of {files} are gross errors" if len(rows) > 1 else f"One row of {files} is a gross error"


def _uneven(final: Fit) -> str:
    """A sentence on rows with most of the error that are too many for gross errors; may be empty."""
    if final.spread < NO_NOISE:
        return ""
    dataset, squares = final.model.dataset, final.row_squares
    names, number = np.unique(dataset.points.names if dataset.format.named_points else (), return_inverse=True)
    shares = np.bincount(number, squares) / squares.sum() if len(names) > 1 else np.zeros(1)
    if shares.max() < CREDIBLE_MASS:
        return f" Most of the error is at poses {shortened(_worst_poses(final))}: has something moved?"
    return f" Nearly all of the error is in the rows of point {names[shares.argmax()]}: has it moved?"


def _worst_poses(final: Fit) -> list[str]:
    """The fewest poses that hold most of the squared error, the worst first."""
    squares, names = final.pose_squares, final.model.dataset.poses.names
    order = np.argsort(-squares)
    most = np.searchsorted(np.cumsum(squares[order]), EVEN * squares.sum()) + 1
    return [names[i] for i in order[:most]]


def _beyond_stated(noise: NoiseModel) -> str:
    """A sentence on rows with far more scatter than stated; may be empty."""
    if (times := over_stated(noise)) < MOST_OVER_STATED:
        return ""
    return f" Rows scatter {times:.0f} times as much as [noise] states: correct it, or look for another cause."


def shortened(poses: Sequence[str]) -> str:
    """The first names of poses, and the number of the others."""
    more = len(poses) - NAMED
    return listed([*poses[:NAMED], f"{more} more"] if more > 0 else list(poses))


def _are_whole(dataset: Dataset, rows: Ints) -> bool:
    return len(rows) > 0 and len(np.unique(dataset.points.pose[rows])) == len(outlying_poses(dataset, rows))
