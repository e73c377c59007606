"""Readings at the times of measurements, interpolated between the two around each; and two logs by two instruments."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.csv_tables import CsvTable, finite, numbers
from robolaser.data.data_tables import motions_of, points_of
from robolaser.data.dataset import COMMAND, Dataset, Poses
from robolaser.data.sensor_format import QUATERNION
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import exp_so3, log_so3, pose

TOLERANCE: Final = "tolerance_s"  # option with the largest time between a reading and a measurement
LONGEST_S = 10.0
CLOCKS: Final = "clocks"  # option for two files with different clocks
SURE: Final = 5.0  # standard errors of an offset that is reported
SPAN_S: Final = 0.3  # over which a turn is measured: long against the noise of one reading, short against a move
FINEST_S: Final = 0.02  # grid of the search
MOST_STEPS: Final = 200_000  # of that grid
ALIKE: Final = 0.8  # correlation of turning speeds from which both are of one motion: a judgement
PARTS: Final = 20  # of the streams, whose scatter gives the standard error: neighbouring rows share readings
FEWEST: Final = 2 * PARTS  # rows


@final
@dataclass(frozen=True)
class Match:
    """The readings around each of m times."""

    before: Ints  # number of the reading before, (m,)
    after: Ints  # number of the reading after, (m,); the same at the readings' own time
    share: Array  # of the way from the one to the other, (m,)
    near: Bools  # whether both are within the tolerance, (m,)
    away_s: Array  # how far the nearest reading is, (m,) [s]

    def values(self, readings: Array) -> Array:
        """Readings (n, ...) at the times, linearly between the two, (m, ...)."""
        share = self.share.reshape(-1, *[1] * (readings.ndim - 1))
        return (1 - share) * readings[self.before] + share * readings[self.after]

    def motions(self, T: Array) -> Array:
        """Rigid motions (n, 4, 4) at the times: positions linearly, rotations along the shortest way, (m, 4, 4)."""
        R, R_after = T[self.before, :3, :3], T[self.after, :3, :3]
        turn = log_so3(np.swapaxes(R, -1, -2) @ R_after)
        return pose(R @ exp_so3(self.share[:, None] * turn), self.values(T[:, :3, 3]))


def match(readings_s: Array, at_s: Array, tolerance_s: float) -> Match:
    """Match times (m,) with sorted ones of readings, (n,), within a tolerance [s]; nothing is extrapolated."""
    n = len(readings_s)
    after = np.searchsorted(readings_s, at_s)
    inside = (after < n) & ((after > 0) | (readings_s[np.minimum(after, n - 1)] == at_s))
    after = np.minimum(after, n - 1)
    before = np.maximum(np.where(readings_s[after] == at_s, after, after - 1), 0)
    gap = readings_s[after] - readings_s[before]
    share = np.divide(at_s - readings_s[before], gap, out=np.zeros(len(at_s)), where=gap > 0)
    away = np.stack([np.abs(at_s - readings_s[before]), np.abs(at_s - readings_s[after])])
    near = inside & (away.max(axis=0) <= tolerance_s)
    return Match(before, after, np.clip(share, 0.0, 1.0), near, away.min(axis=0))


def tolerance_of(further: Mapping[str, str], file: str) -> float:
    """The stated tolerance [s]."""
    if TOLERANCE not in further:
        raise UsageError(
            f"{file}: how far in time may a reading of the arm be from a measurement? State it in seconds with"
            f" --set {TOLERANCE}=0.02, for example."
        )
    value = finite(further[TOLERANCE])
    if not 0 < value <= LONGEST_S:
        raise UsageError(f"--set {TOLERANCE}={further[TOLERANCE]}: expected seconds, above 0 and up to {LONGEST_S:g}.")
    return value


def with_readings(
    known: Bools, away_s: Array, tolerance_s: float, *, file: str, what: str, source: str = ""
) -> tuple[Ints, tuple[str, ...]]:
    """Numbers of the measurements that have readings of the arm, (k,), and messages on the others.

    By whether each has, (m,), and how far its nearest reading is, (m,) [s]. The file is that of the measurements,
    `what` the name of one of them, `source` that of the readings.
    """
    of = f" ({source})" if source else ""
    if not known.any():
        nearest = f"{away_s.min():.3g} s away" if len(away_s) else f"none: there is no {what}"
        raise DataError(
            f"{file}: no {what} has readings of the arm{of} within {tolerance_s:g} s before and after it; the nearest"
            f" is {nearest}. Are the clocks different, or were they recorded at different times?",
            file=file,
        )
    kept = np.flatnonzero(known)
    without = len(known) - len(kept)
    left_out = f"{file}: {without} of {len(known)} {what}s, without readings of the arm within {tolerance_s:g} s"
    return kept, (f"{left_out} before and after",) if without else ()


def joined_by_time(
    log: Dataset, measured: CsvTable, further: Mapping[str, str], arm: str
) -> tuple[Dataset, str, tuple[str, ...]]:
    """Measurements, each with the readings of the arm's log interpolated at its time.

    They have the columns of points.csv, with `time_s` in the place of `pose`. Options are `tolerance_s`, and `clocks`
    where two clocks timed the logs; `arm` is the file of the arm's.

    Returns:
        The data set; the correction of the measured times; and messages on rows left out.
    """
    tolerance = tolerance_of(further, measured.file)
    if log.poses.time_s is None:
        raise DataError(f"{arm} has no times: name their column with --column poses.time_s=NAME.", file=arm)
    once = _increasing(log.poses.time_s)
    left_out = _repeated(arm, len(log.poses) - len(once))
    log = replace(log, poses=log.poses.take(once))
    readings_s = log.poses.time_s
    assert readings_s is not None
    at_s = measured.numbers(["time_s"])[:, 0]
    later_s, words, warnings = _clock(log, measured, at_s, tolerance, further.get(CLOCKS), arm)
    at_s = at_s + later_s
    found = match(readings_s, at_s, tolerance)
    kept, without = with_readings(found.near, found.away_s, tolerance, file=measured.file, what="row")
    times, number = np.unique(at_s[kept], return_inverse=True)
    poses = _readings(log.poses, match(readings_s, times, tolerance), times)
    seen = measured.take(kept)
    seen = replace(seen, columns={**seen.columns, "pose": tuple(poses.names[i] for i in number.tolist())})
    if "repeat" not in seen:
        _, first = np.unique([seen.cells("pose"), seen.texts("point")], axis=1, return_index=True)
        seen = seen.take(np.sort(first))
        left_out += _repeated(measured.file, len(kept) - len(first))
    dataset = replace(log, poses=poses, warnings=(*log.warnings, *warnings))
    return replace(dataset, points=points_of(seen, dataset)), words, (*left_out, *without)


def _repeated(file: str, count: int) -> tuple[str, ...]:
    return (f"{file}: {count} rows, whose times repeat those of others",) if count else ()


def _increasing(time_s: Array) -> Ints:
    """Numbers of the rows in the order of their times, without those that repeat the previous time."""
    order = np.argsort(time_s, kind="stable")
    return order[np.diff(time_s[order], prepend=-np.inf) > 0]


def _clock(
    log: Dataset, measured: CsvTable, at_s: Array, tolerance_s: float, stated: str | None, arm: str
) -> tuple[float, str, tuple[str, ...]]:
    """The correction of the times (m,) of rows to the arm's clock [s], also in words; and warnings."""
    if QUATERNION[0] not in measured:
        if stated is not None:
            raise UsageError(
                f"--set {CLOCKS}={stated}: points have no orientation, from which a clock difference is"
                " estimated. Import bodies (--sensor pose), or correct the times."
            )
        return 0.0, "", ()
    if stated not in (None, "differ"):
        raise UsageError(f"--set {CLOCKS}={stated}: expected differ, or nothing where both files have one clock.")
    order = _increasing(at_s)
    T = motions_of(measured)[order]
    assert log.poses.time_s is not None
    found = _clock_offset(log.poses.time_s, log.flange(), at_s[order], T)
    if found is None:
        if stated is None:
            return 0.0, "", ()
        raise DataError(
            f"The rotations of {measured.file} and {arm} agree at no offset of their clocks: at least {FEWEST} rows of"
            " both must be of one motion that turns the flange.",
            file=measured.file,
        )
    offset, std = found
    words = f"{offset:.4f} ± {max(std, 1e-4):.4f} s"
    if stated is not None:
        return offset, f" + {words} (by the rotations of both)", ()
    warning = (
        f"The clocks of {arm} and {measured.file} seem to differ: their rotations agree if {words} is added to the"
        f" times of {measured.file}. --set {CLOCKS}=differ does so."
    )
    return 0.0, "", (warning,) if abs(offset) >= max(SURE * std, tolerance_s / 10) else ()


def _readings(arm: Poses, at: Match, times: Array) -> Poses:
    """The arm at times, (m,): numbers and commands are interpolated, all else is that of the reading before."""
    before = arm.take(at.before)
    known = {name: getattr(arm, name) for name in ("q", "qd", "payload_kg", "temperature_c")}
    between: dict[str, Any] = {name: at.values(values) for name, values in known.items() if values is not None}
    commands = {name: numbers(cells) for name, cells in arm.extra.items() if name.startswith(COMMAND)}
    cells_at = {name: map(repr, at.values(values).tolist()) for name, values in commands.items() if values is not None}
    return replace(
        before,
        names=tuple(str(i) for i in range(1, len(times) + 1)),
        time_s=times,
        T_base_flange=None if arm.T_base_flange is None else at.motions(arm.T_base_flange),
        following={joint: at.values(values) for joint, values in arm.following.items()},
        extra={**before.extra, **{name: tuple(cells) for name, cells in cells_at.items()}},
        **between,
    )


def _clock_offset(to_s: Array, T_to: Array, from_s: Array, T_from: Array) -> tuple[float, float] | None:
    """The clock offset between two rigidly connected bodies, to be added to the times of the second.

    Times increase, (n,) and (m,); poses are (n, 4, 4) and (m, 4, 4). The angle by which both turn is the same, whatever
    their frames are. A grid of offsets is searched by the agreement of turning speeds; least squares of the angles then
    refine the best.

    Returns:
        The offset and its standard error [s]; None where the streams are too short or turn too little, or do not turn
        alike at any offset.
    """
    from scipy.optimize import minimize_scalar  # noqa: PLC0415 - both take seconds to import, and few files have two clocks
    from scipy.signal import correlate  # noqa: PLC0415

    if min(len(to_s), len(from_s)) < FEWEST:
        return None
    longest = max(np.ptp(to_s), np.ptp(from_s))
    step = max(float(np.median(np.diff(to_s))), float(np.median(np.diff(from_s))), FINEST_S, longest / MOST_STEPS)
    a, b = (
        _rotation_angles(s, T, np.arange(s[0], s[-1] - step, step), step) for s, T in ((to_s, T_to), (from_s, T_from))
    )
    energy = correlate(a**2, np.ones_like(b)) + correlate(np.ones_like(a), b**2)
    alike = np.where(energy > 0.5 * energy.max(), 2.0 * correlate(a, b) / np.maximum(energy, 1e-12), 0.0)
    best = int(alike.argmax())
    if alike[best] < ALIKE:
        return None
    start = to_s[0] - from_s[0] + (best - (len(b) - 1)) * step
    span = max(SPAN_S, step)
    at = from_s[from_s < from_s[-1] - span]
    own = _rotation_angles(from_s, T_from, at, span)

    def apart(offset: float) -> Array:
        inside = (at + offset >= to_s[0]) & (at + offset + span <= to_s[-1])
        return np.where(inside, _rotation_angles(to_s, T_to, at + offset, span) - own, 0.0)

    # SciPy's tolerance grows with its variable, and clocks may be an epoch apart: the search variable is small
    found = start + minimize_scalar(
        lambda rest: np.square(apart(start + rest)).sum(), bounds=(-step, step), method="bounded",
        options={"xatol": 1e-6},
    ).x  # fmt: skip
    slope = (apart(found + 0.1 * step) - apart(found - 0.1 * step)) / (0.2 * step)
    scores = [float(part.sum()) for part in np.array_split(slope * apart(found), PARTS)]
    return float(found), float(np.sqrt(np.square(scores).sum()) / np.square(slope).sum())


def _rotation_angles(times_s: Array, T: Array, at_s: Array, span_s: float) -> Array:
    """Rotation angle of a body from each time (k,) over a span [s], (k,) [rad]."""
    R, later = (match(times_s, at, np.inf).motions(T)[:, :3, :3] for at in (at_s, at_s + span_s))
    return np.asarray(np.linalg.norm(log_so3(np.swapaxes(R, -1, -2) @ later), axis=-1))
