"""Two logs by two instruments, the arm's and that of what was measured, brought together by time."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.csv_tables import CsvTable
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.importers.clock_offset import CLOCKS, Trajectory, by_one_clock
from robolaser.data.importers.time_matching import Match, match, tolerance_of, with_readings
from robolaser.data.point_table import points_of
from robolaser.data.sensor_format import QUATERNION, XYZ
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import from_quaternion, pose


def joined_by_time(
    log: Dataset, measured: CsvTable, further: Mapping[str, str], *, arm: str = "the arm's log", what: str = "row"
) -> tuple[Dataset, str, tuple[str, ...], tuple[str, ...]]:
    """What was measured, each with the arm's readings at its time, between the two around it.

    Args:
        log: The arm's log: a data set of its poses, with times.
        measured: The columns of points.csv, with `time_s` in the place of `pose`.
        further: Options: `tolerance_s`, and `clocks` where two clocks timed the logs.
        arm: The arm's log, in words.
        what: What is measured, in the singular.

    Returns:
        The data set; what was added to the times that were measured; warnings; and what is left out.

    Raises:
        DataError: A log has no times, or nothing was measured near any of the arm's readings.
        UsageError: No tolerance is stated; or clocks differ, and no bodies were measured, whose turns tell by how much.
    """
    tolerance = tolerance_of(further, measured.file)
    if log.poses.time_s is None:
        raise DataError(
            "The arm's log has no times: name their column with --column poses.time_s=NAME.", file="poses.csv"
        )
    log = replace(log, poses=log.poses.take(_increasing(log.poses.time_s)))
    readings_s = log.poses.time_s
    assert readings_s is not None
    at_s, words, warnings = _times(log, measured, tolerance, further, arm)
    found = match(readings_s, at_s, tolerance)
    kept, left_out = with_readings(found.near, found.away_s, tolerance, file=measured.file, what=what)
    times, number = np.unique(at_s[kept], return_inverse=True)
    poses = _readings(log.poses, match(readings_s, times, tolerance), times)
    names = tuple(poses.names[i] for i in number.tolist())
    dataset = replace(log, poses=poses)
    seen = measured.take(kept)
    seen = replace(seen, header=[*seen.header, "pose"], columns={**seen.columns, "pose": names})
    return replace(dataset, points=points_of(seen, dataset)), words, warnings, left_out


def _increasing(time_s: Array) -> Ints:
    """Numbers of the rows in the order of their times, without those that repeat the time of the one before."""
    order = np.argsort(time_s, kind="stable")
    return order[np.diff(time_s[order], prepend=-np.inf) > 0]


def _times(
    log: Dataset, measured: CsvTable, tolerance_s: float, further: Mapping[str, str], arm: str
) -> tuple[Array, str, tuple[str, ...]]:
    """When rows were measured, by the arm's clock, (m,) [s]; what was added; and warnings."""
    at_s = measured.numbers(["time_s"])[:, 0]
    if QUATERNION[0] not in measured:
        if CLOCKS in further:
            raise UsageError(
                f"--set {CLOCKS}={further[CLOCKS]}: points by themselves do not turn, so they do not show by how much"
                " clocks differ. Import bodies (--sensor pose), or correct the times."
            )
        return at_s, "", ()
    order = _increasing(at_s)
    turns = from_quaternion(measured.numbers(QUATERNION)[order])
    assert log.poses.time_s is not None
    flange = Trajectory(arm, log.poses.time_s, log.flange())
    body = Trajectory(measured.file, at_s[order], pose(turns, measured.numbers(XYZ)[order]))
    moved, words, warnings = by_one_clock(flange, body, tolerance_s, further)
    return at_s + (moved.time_s[0] - body.time_s[0]), words, warnings


def _readings(arm: Poses, at: Match, times: Array) -> Poses:
    def between(values: Array | None) -> Array | None:
        return None if values is None else at.values(values)

    return Poses(
        tuple(str(i) for i in range(1, len(times) + 1)),
        times,
        q=between(arm.q),
        qd=between(arm.qd),
        T_base_flange=None if arm.T_base_flange is None else at.motions(arm.T_base_flange),
        payload_kg=between(arm.payload_kg),
        temperature_c=between(arm.temperature_c),
        following={joint: at.values(values) for joint, values in arm.following.items()},
        extra={name: tuple(cells[i] for i in at.before.tolist()) for name, cells in arm.extra.items()},
    )
