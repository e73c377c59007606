"""Misread data: with another reading, they fit far better."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.calibration.other_readings import (
    FEWEST_POSES,
    ROWS,
    SHIFTS,
    Hypothesis,
    other_arms,
    read_otherwise,
    with_rows_moved,
)
from robolaser.calibration.result import rms, rms_of_poses
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import evenly, rows_of_each, subsampled
from robolaser.errors import RobolaserError
from robolaser.estimation.multistart import SEARCH_POINTS
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.forward_model import Model, of_data

FALLS = 5.0
"""Factor by which another reading of the joints must lower the error to be reported. A judgement: exchanged columns
leave centimetres or more, the largest effects of the library millimetres."""
MOST_POSES, ROWS_OF_A_POSE = 40, 8  # a camera whose lens is unknown is found from six corners an image and more
BEST = 3.0  # factor by which the error of any other hypothesis must be larger: else it is not known what is wrong
MISREAD = 0.99  # probability of a reading that fits so much better. A judgement
OTHER_ARM_RMS_M = 2e-3
"""Error above which another arm of the same joints is tried. A judgement: effects leave less, as a rule; generations of
an arm differ by centimetres."""
STEPS = 12  # of each descent; an error that has not fallen by then is no sign
COARSE, NANOMETRE = 1e-6, 1e-9


@final
@dataclass(frozen=True)
class Misread:
    """Data that fit far better when they are read otherwise."""

    sentence: str
    shift: int  # by how many poses the rows of points.csv are off; 0 where something else is wrong
    share: float  # of the mean squared error, which there is not when they are read so


def misread(model: Model, rms_m: float) -> Misread | None:
    """What seems to be misread; None where the error of fitted points is no sign of it, or nothing explains it.

    Each hypothesis is fitted to some rows from its own start values, in a few steps. Without a fit, the error is
    infinite.
    """
    if rms_m < OTHER_ARM_RMS_M:
        return None
    few = _some(model.dataset)
    readings = [*other_arms(few), *((*read_otherwise(few), *_slipped(few)) if rms_m >= SETUP_RMS_M else ())]
    if not readings:
        return None
    as_read = _error(few)
    scales = np.array([reading.scale for reading in readings])
    errors = np.array([_error(reading.dataset) for reading in readings]) / scales
    order = np.argsort(errors)
    found, best = readings[int(order[0])], errors[order[0]]
    is_alike = np.array([one is found or (found.alike != "" and one.alike == found.alike) for one in readings])
    is_alike &= errors <= BEST * best
    second = errors[~is_alike].min(initial=np.inf)
    if not np.isfinite(best) or best * FALLS > as_read or best * BEST > second:
        return None
    instead = f" instead of {millimetres(as_read)}" if np.isfinite(as_read) else ""
    fault, *others = dict.fromkeys(readings[i].fault for i in np.flatnonzero(is_alike).tolist())
    corrected_m = (errors * scales)[is_alike].min()
    either = "".join(f", or {other[0].lower()}{other[1:]}" for other in others)
    where = "one of the two" if others else found.where
    return Misread(
        f"{fault}{either}: with that corrected, the error is {millimetres(corrected_m)}{instead}. Correct {where}.",
        found.shift,
        float(1.0 - (best / as_read) ** 2),
    )


def _some(dataset: Dataset) -> Dataset:
    """Rows that suffice to distinguish readings; for poses that see a whole target, as many per sensor as locate it."""
    if dataset.format.named_points:
        return subsampled(dataset, SEARCH_POINTS)
    poses = np.unique(dataset.points.pose)
    rows = np.flatnonzero(np.isin(dataset.points.pose, poses[evenly(len(poses), MOST_POSES)]))
    seen = dataset.points.pose * max(1, len(dataset.members)) + dataset.sensor_of_row
    return replace(dataset, points=dataset.points.take(rows[rows_of_each(seen[rows], ROWS_OF_A_POSE)]))


def _error(dataset: Dataset) -> float:
    """Root-mean-square error of the points after a short fit [m]; infinite where there is none."""
    if (found := _short_fit(dataset)) is None:
        return np.inf
    model, x = found
    error = rms(model.in_metres(x, model.residuals(x[None])[0]))
    return error if np.isfinite(error) else np.inf


def millimetres(length_m: float) -> str:
    """A rough error with its unit."""
    return f"{1e3 * length_m:.0f} mm" if length_m >= 0.01 else f"{1e3 * length_m:.2g} mm"


def _short_fit(dataset: Dataset) -> tuple[Model, Array] | None:
    """The model without effects, and its parameters (d,) a few steps from its start; None without a start."""
    try:
        model = Model(dataset)
        start = model.fix_gauge(model.parameters.nominal)
        return model, solve(Problem.of(model), start[None], tol=COARSE, most_steps=STEPS).x[0]
    except (RobolaserError, np.linalg.LinAlgError):
        return None


def _slipped(dataset: Dataset) -> Iterator[Hypothesis]:
    """All rows from some pose on moved by one pose, either way: a pose was lost there or counted twice.

    Or to some pose, where the opposite happened. Each session is tried by itself, since placements differ between them.
    """
    session = dataset.session_of_pose
    for number in np.unique(session):
        own = np.flatnonzero(session == number)
        rows = np.flatnonzero(session[dataset.points.pose] == number)
        for shift, *ends in _slips(dataset.of_poses(session == number)):
            first, last = own[ends]
            until = " on" if last == own[-1] else f" to pose {dataset.poses.names[last]}"
            whose = f"the points, or images, seem to belong to the pose {SHIFTS[shift]} theirs"
            fault = f"From pose {dataset.poses.names[first]}{until}, {whose}"
            yield Hypothesis(with_rows_moved(dataset, shift, first, last, of=rows), fault, ROWS, shift)


def _slips(dataset: Dataset) -> Iterator[tuple[int, int, int]]:
    """By how many poses the rows of one session may have slipped, from which pose on, and to which, or the last.

    The first third of the poses is fitted as read, the last third as shifted: one of the two is entirely on one side
    of the slip. By either fit, the slip is at the pose that minimises the errors of all poses.
    """
    poses = np.unique(dataset.points.pose)
    if len(poses) < 3 * FEWEST_POSES or (dataset.format.named_points and _names_differ(dataset, poses)):
        return
    third = len(poses) // 3
    of_first = _short_fit(_of(dataset, poses[:third]))
    for shift in SHIFTS:
        moved = with_rows_moved(dataset, shift)
        fits = of_first, _short_fit(_of(moved, poses[-third:] + shift))
        found = [_likeliest(dataset, moved, shift, *fit) for fit in fits if fit is not None]
        for gain, first, last in dict.fromkeys(max(likeliest) for likeliest in zip(*found, strict=True)):
            moves_all = first <= poses[0] and last >= poses[-1]
            if gain > 0.0 and not (moves_all and dataset.sessions is None):  # other sessions may be right
                yield shift, first, last


def _of(dataset: Dataset, poses: Ints) -> Dataset:
    return replace(dataset, points=dataset.points.take(np.flatnonzero(np.isin(dataset.points.pose, poses))))


def _names_differ(dataset: Dataset, poses: Ints) -> bool:
    """Whether a third of the poses shows other points than all do: it then does not determine all placements."""
    third = len(poses) // 3
    ends = (_of(dataset, some).points.names for some in (poses[:third], poses[-third:]))
    return any(set(names) != set(dataset.points.names) for names in ends)


def _likeliest(as_read: Dataset, moved: Dataset, shift: int, model: Model, x: Array) -> list[tuple[float, int, int]]:
    """The slips that lower the errors most, to the end and to any pose: by how much, their first pose, and their last.

    The errors are lowered by a sum of logarithms over the poses.
    """
    count = len(as_read.poses)
    here, there = (_errors(of_data(model, each), x, count) for each in (as_read, moved))
    gains = np.cumsum(np.nan_to_num(np.log(here) - np.log(np.roll(there, -shift)))[::-1])[::-1]
    after = np.append(gains[1:], 0.0)
    between = gains - np.minimum.accumulate(after[::-1])[::-1]
    first = int(np.argmax(between))
    last = count - 1 - int(np.argmin(after[first:][::-1]))
    return [(float(gains.max()), int(np.argmax(gains)), count - 1), (float(between[first]), first, last)]


def _errors(model: Model, x: Array, count: int) -> Array:
    """Root-mean-square error of each pose [m], at least a nanometre."""
    of_poses = rms_of_poses(model.in_metres(x, model.residuals(x[None])[0]), model.dataset.points.pose, count)
    return np.maximum(of_poses, NANOMETRE)
