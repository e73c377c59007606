"""Checks that the data suffice, before a calibration, and that they were read correctly, after it."""

from collections.abc import Iterable

import numpy as np

from robolaser.arrays import Bools
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import evenly
from robolaser.errors import DataError, EstimationError
from robolaser.estimation.noise_estimate import LEVER_M
from robolaser.estimation.problem import Problem
from robolaser.geometry.hand_eye import LEAST_TURN, principal_turns, undetermined_reason
from robolaser.model.forward_model import Model, depends_on_trajectory, jacobian, with_rows

RANK_TOLERANCE = 1e-6  # of a pose's Jacobian, relative to its largest singular value
SAMPLE = 20  # poses whose Jacobians are compared
ALIKE = 6  # decimals [m], and of rotation matrices, to which two poses must agree to count as one
APART_M = 1e-3  # poses nearer to each other show the same errors. A judgement
SETUP_RMS_M = 0.01
"""Error of fitted points above which the description of the cell is wrong: no effect of the library is so large."""
SETUP_MEASURED_RMS_M = 0.05
"""The same where flange poses were measured: by cameras or by hand, they are off by centimetres. A judgement."""
SETUP_ON_BOUNDS = 1 / 3
"""Share of the parameters with given bounds that end on one, above which the bounds or the description are wrong."""
HEADER = 2  # the first row of a table is line 2


def check_poses(problem: Problem) -> None:
    """Check that there are enough poses for the parameters.

    One pose can fix at most as many combinations of parameters as the rank of its rows' Jacobian.

    Raises:
        EstimationError: There are too few poses; it names the number needed.
    """
    model, free = problem.model, ~problem.fixed
    if not free.any():
        return
    points = model.dataset.points
    poses = np.unique(points.pose)
    sample = poses[evenly(len(poses), SAMPLE)]
    rows = np.flatnonzero(np.isin(points.pose, sample))
    some = model if depends_on_trajectory(model) else with_rows(model, rows)
    J = np.nan_to_num(jacobian(some, problem.parameters.nominal[None])[0][free] * problem.scale[free, None, None])
    pose_of_row = some.dataset.points.pose
    blocks = [J[:, pose_of_row == pose].reshape(len(J), -1) for pose in sample]
    ranks = [np.linalg.matrix_rank(block, rtol=RANK_TOLERANCE) for block in blocks]
    parameters = len(J)
    needed = int(np.ceil(parameters / max(1.0, float(np.median(ranks)))))
    different = len(np.unique(model.dataset.flange()[poses].round(ALIKE), axis=0))
    if different < needed:
        differing = (
            f", of which only {different} differ{'s' if different == 1 else ''}," if different < len(poses) else ""
        )
        raise EstimationError(
            f"{len(poses)} pose{'s' if len(poses) != 1 else ''} with points{differing} cannot determine {parameters} "
            f"parameters: at least {needed} are needed. Measure more poses, turned and tilted against each other."
        )


def different_poses(dataset: Dataset, most: int) -> int:
    """Number of poses with points of which none is within `APART_M` of another one, a turn counted at `LEVER_M`.

    No more than `most` are counted.
    """
    T = dataset.flange()[np.unique(dataset.points.pose)]
    flat = np.concatenate([T[:, :3, 3], LEVER_M * T[:, :3, :3].reshape(-1, 9)], axis=1)
    count = 0
    while len(flat) and count < most:
        flat = flat[np.linalg.norm(flat - flat[0], axis=1) > APART_M]
        count += 1
    return count


def check_orientations(model: Model) -> None:
    """Check that the flange turns enough for one of the blocks: the others share with it.

    Raises:
        EstimationError: It does not.
    """
    T, needy = model.dataset.flange(), [block.sensor for block in model.blocks if block.sensor.parameters.two_axes]
    reasons = [undetermined_reason(T[np.unique(sensor.dataset.points.pose)]) for sensor in needy]
    if len(needy) == len(model.blocks) and all(reasons):
        raise EstimationError(reasons[0])


def travel_warnings(model: Model, apart: Iterable[str]) -> list[str]:
    """Warning on named parameters that data do not determine, if the flange turns about one axis at most."""
    carried = [name for name in apart if name.startswith("hand_eye.")]
    if not carried:
        return []
    seen = np.unique(model.dataset.points.pose)
    _, turns, _ = principal_turns(model.dataset.flange()[seen, :3, :3])
    if turns[1] >= LEAST_TURN:
        return []
    turning = "turns about one axis only" if turns[0] >= LEAST_TURN else "never turns"
    return [
        f"The flange {turning}. Its travel determines the orientations, but not where the sensor and the target are on"
        f" their own: {', '.join(carried)} could have any value, if the target moves with it. Do not use the"
        " exported position; turn the flange about two axes, by 30° or more."
    ]


def check_target(model: Model) -> None:
    """Check that a placed target is in front of the camera, with the nominal parameters, for most rows.

    Raises:
        DataError: It is behind the camera.
    """
    behind = ~model.blocks.in_view(*model.at(model.parameters.nominal))
    if model.dataset.placed and behind.mean() > 0.5:
        pose = model.dataset.points.pose
        row = int(np.argmax(behind))
        where = f"points.csv, row {row + HEADER} (pose {model.dataset.poses.names[pose[row]]})"
        raise DataError(
            f"{where}: with the nominal parameters the target point is behind the camera, as are "
            f"{int(behind.sum())} of {len(behind)} rows. Check the target's frame and units, bracket_quat and the "
            "flange.",
            file="points.csv",
            row=row + HEADER,
        )


def setup_limit_m(dataset: Dataset) -> float:
    """Error of fitted points above which the data set describes its cell wrongly."""
    return SETUP_MEASURED_RMS_M if dataset.robot is None else SETUP_RMS_M


def setup_warning(model: Model, on_bound: Bools, rms_m: float) -> str | None:
    """A warning that start values, bounds, axes or units seem to be wrong; None without evidence.

    Judged by the parameters on a bound (d,), effects last, and the root-mean-square error of the fitted points.
    """
    given = np.array([item.given for item in model.sensor_parameters.items])
    ended = int(on_bound[: len(given)][given].sum())
    reasons = []
    if given.any() and ended / given.sum() >= SETUP_ON_BOUNDS:
        reasons.append(
            f"{ended} of {given.sum()} parameters ended on their bounds: the bounds exclude the best fit, or the data "
            "set describes the cell wrongly."
        )
    if rms_m >= setup_limit_m(model.dataset):
        whose = "no measured flange pose" if model.dataset.robot is None else "no real arm"
        reasons.append(
            f"Fitted points are {100 * rms_m:.2g} cm off: {whose} has such an error, so the data set describes the"
            " cell wrongly; only robot.urdf is exported."
        )
    if not reasons:
        return None
    axis = "stripe_axis, " if model.blocks.has_laser_plane else ""
    return (
        f"{' '.join(reasons)} Do not use this result. Check the start values in [parameters], {axis}the joint angles' "
        "units and signs, the flange, and the units of points.csv, before you look for effects."
    )
