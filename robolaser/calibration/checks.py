"""Whether data can be calibrated from at all, said before the search and not after it."""

import numpy as np

from robolaser.errors import DataError, EstimationError
from robolaser.estimation.problem import Problem
from robolaser.geometry.rigid_motion import inverse
from robolaser.model.derivatives import jacobian
from robolaser.model.forward_model import Model
from robolaser.model.pose_blocks import depends_on_trajectory, with_rows
from robolaser.model.sensors.stripe import Stripe

RANK_TOLERANCE = 1e-6  # of a pose's Jacobian, relative to its largest singular value
SAMPLE = 20  # poses that are looked at
ALIKE = 6  # decimals [m], and of rotation matrices, in which poses that differ at all differ
HEADER = 2  # the first row of a table stands in line 2


def check_poses(problem: Problem) -> None:
    """See that there are enough poses for the parameters.

    One pose can fix no more combinations of parameters than the rank of its rows' derivatives.

    Raises:
        EstimationError: Says how many are needed.
    """
    model, free = problem.model, ~problem.fixed
    points = model.dataset.points
    poses = np.unique(points.pose)
    sample = poses[np.unique(np.linspace(0, len(poses) - 1, min(len(poses), SAMPLE)).astype(int))]
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
            f"{len(poses)} pose{'s' if len(poses) != 1 else ''} with points{differing} cannot fix {parameters} "
            f"parameters: at least {needed} are needed. Measure more poses, turned and tilted against each other."
        )


def check_target(model: Model) -> None:
    """See that a placed target lies in front of the camera, with the nominal parameters, for most rows.

    Raises:
        DataError: It lies behind it.
    """
    sensor = model.sensor
    if not isinstance(sensor, Stripe) or not model.dataset.placed:
        return
    values = model.parameters.values(model.parameters.nominal[None])
    perturb = model.perturb(values)
    T_base_camera = model.flange(values, perturb) @ sensor.mount(values, perturb)
    pose = model.dataset.points.pose
    T_camera_base = inverse(T_base_camera)[0, pose, 2]
    behind = (sensor.target(values, perturb)[0] * T_camera_base[:, :3]).sum(axis=-1) + T_camera_base[:, 3] <= 0
    if behind.mean() > 0.5:
        row = int(np.argmax(behind))
        raise DataError(
            f"points.csv, row {row + HEADER} (pose {model.dataset.poses.names[pose[row]]}): with the nominal "
            f"parameters the target point lies behind the camera, as do {int(behind.sum())} of {len(behind)} rows. Check the "
            "target's frame and units, bracket_quat and the flange.",
            file="points.csv",
            row=row + HEADER,
        )
