"""Errors of a moving arm's model on held-out motions, in the unit of the rows and at the flange."""

from dataclasses import dataclass
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.motion.log import MotionLog

FEWEST_RUNS = 4  # to hold out whole runs, in as many folds; with fewer, blocks of rows
BLOCKS = 12
FLANGE_ROWS = 1_500  # at which the arm's Jacobian is computed
RESAMPLED = 400


@final
@dataclass(frozen=True, eq=False)
class KindGap:
    """Errors of the rows of one kind: RMS by joint, (j,); NaN where a joint has none."""

    kind: str  # of rows
    unit: str
    nominal: Array
    calibrated: Array
    after: Array
    noise_floor: Array
    count: int  # rows that were compared

    def whole(self, name: str) -> float:
        """RMS over all joints."""
        return float(root_mean_squares(getattr(self, name)))


def folds(run: Ints) -> Ints:
    """Which fold each row is held out in, (n,): whole runs, or blocks of rows where there are too few runs."""
    _, group, counts = np.unique(run, return_inverse=True, return_counts=True)
    if len(counts) < FEWEST_RUNS:
        return runs_or_blocks(run) % FEWEST_RUNS
    place = np.argsort(np.argsort(-counts, kind="stable"))
    return place[group] % FEWEST_RUNS


def runs_or_blocks(run: Ints) -> Ints:
    """Independent groups of rows, (n,): whole runs, or blocks of rows where there are too few runs."""
    if len(np.unique(run)) >= FEWEST_RUNS:
        return run
    return np.arange(len(run)) * BLOCKS // max(len(run), 1)


def where_lower(after: Array, before: Array, run: Ints, least_share: float) -> tuple[Bools, Array]:
    """Errors (n, j) of joints whose squares fall significantly and by a least share, else those before, (n, j).

    Returns:
        Which joints' fall, (j,), and the errors.
    """
    of_row, least = runs_or_blocks(run), least_share * np.nansum(before**2, axis=0)
    fall = np.nan_to_num(before**2 - after**2)
    falls = np.array([fall[of_row == number].sum(axis=0) for number in np.unique(of_row)])
    lower = np.asarray(falls.sum(axis=0) > np.maximum(least, np.sqrt((falls**2).sum(axis=0))))
    return lower, np.where(lower, after, before)


def root_mean_squares(errors: Array) -> Array:
    """RMS of each column without its gaps, (n, j) -> (j,), or of values (n,); NaN where there are none."""
    there = np.isfinite(errors)
    count = there.sum(axis=0)
    squares = np.where(there, errors, 0.0) ** 2
    return np.asarray(np.where(count > 0, np.sqrt(squares.sum(axis=0) / np.maximum(count, 1)), np.nan))


def root_mean_squares_of_runs(errors: Array, run: Ints) -> Array:
    """The same of each run, (n, j) -> (runs, j) or (n,) -> (runs,)."""
    return np.array([root_mean_squares(errors[run == number]) for number in np.unique(run)])


def medians(values: Array) -> Array:
    """Median of each column without its gaps, (n, j) -> (j,); NaN where there are none."""
    known = [column[np.isfinite(column)] for column in values.T]
    return np.array([np.median(column) if len(column) else np.nan for column in known])


def less_means(values: Array, run: Ints) -> Array:
    """Values less the mean of each run, gaps ignored, (n,) or (n, k)."""
    out = values.copy()
    for number in np.unique(run):
        there = np.isfinite(part := out[run == number])
        out[run == number] -= np.where(there, part, 0.0).sum(axis=0) / np.maximum(there.sum(axis=0), 1)
    return out


def white_noise(errors: Array, run: Ints, step: float | None) -> Array:
    """Standard deviation of white noise, (n, j) -> (j,): from differences of neighbours, and of rounding.

    Of white noise the second difference has six times the variance.
    """
    bend = np.full_like(errors, np.nan)
    for j, known in enumerate(np.isfinite(errors.T)):
        rows = np.flatnonzero(known)
        before, here, behind = rows[:-2], rows[1:-1], rows[2:]
        near = (run[behind] == run[before]) & (behind - before == np.min(behind - before, initial=len(run)))
        bend[here[near], j] = (errors[behind, j] - 2.0 * errors[here, j] + errors[before, j])[near]
    white = root_mean_squares(bend) / np.sqrt(6.0)
    return np.asarray(white if step is None else np.maximum(white, step / np.sqrt(12.0)))


def resolution(readings: Array) -> float | None:
    """Resolution of readings: the smallest step that divides all differences; None where there is none."""
    values = np.unique(readings[np.isfinite(readings)])
    steps = np.diff(values)
    steps = steps[steps > 1e-9]
    if len(steps) < 3:
        return None
    step = float(np.min(steps))
    off = np.abs(steps / step - np.round(steps / step))
    return step if float(np.mean(off < 0.05)) > 0.95 else None


def at_flange(log: MotionLog, gap: KindGap, before: Array, after: Array, seed: int) -> tuple[dict[str, Any], Array]:
    """The tracking error at the flange, with the keys of JSON files.

    Args:
        log: Commands and readings.
        gap: Of the tracking rows.
        before: Errors of an ideal arm, (n, j) [rad].
        after: Errors on unseen motions, (n, j) [rad].
        seed: Of the resampling for the interval: of runs, or of blocks of rows where there are too few.

    Returns:
        Root mean squares [mm], and how far the flange moves with each joint, (j,) [mm/rad].
    """
    rows = np.flatnonzero(np.isfinite(after).any(axis=1))
    rows = rows[:: max(1, len(rows) // FLANGE_ROWS)]
    jacobian = log.robot.jacobian(np.nan_to_num(log.q[rows])[None])[0, :, :3]
    squares: dict[str, Array] = {}
    for name, errors in {"nominal": log.q - log.command, "calibrated": before, "after": after}.items():
        moved = 1e3 * np.einsum("rkj,rj->rk", jacobian, np.nan_to_num(errors[rows]))
        squares[name] = (moved**2).sum(axis=1)
    of_row = runs_or_blocks(log.run[rows])
    groups = [squares["after"][of_row == name] for name in np.unique(of_row)]
    sums, counts = np.array([g.sum() for g in groups]), np.array([len(g) for g in groups])
    drawn = np.random.default_rng(seed).integers(0, len(groups), (RESAMPLED, len(groups)))
    means = np.sqrt(sums[drawn].sum(axis=1) / counts[drawn].sum(axis=1))
    noise = (jacobian**2 * np.nan_to_num(gap.noise_floor) ** 2).sum(axis=(1, 2))
    return {
        **{name: float(np.sqrt(each.mean())) for name, each in squares.items()},
        "noise_floor": float(1e3 * np.sqrt(noise.mean())),
        "after_ci95": np.percentile(means, [2.5, 97.5]).tolist(),
    }, 1e3 * np.sqrt((jacobian**2).sum(axis=1).mean(axis=0))
