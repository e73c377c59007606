"""Whether data can be calibrated from at all, said before the search and not after it."""

import numpy as np

from robolaser.errors import TargetUnseen, TooFewPoses
from robolaser.estimation.jacobian import jacobian
from robolaser.estimation.problem import Box
from robolaser.geometry.rigid_motion import inverse
from robolaser.model.forward_model import Model
from robolaser.model.pose_blocks import depends_on_trajectory, with_rows
from robolaser.model.sensors.stripe import Stripe

RANK_TOLERANCE = 1e-6  # of a pose's Jacobian, relative to its largest singular value
ALIKE = 6  # decimals [m], and of rotation matrices, in which poses that differ at all differ
HEADER = 2  # the first row of a table stands in line 2


def check_poses(model: Model, box: Box) -> None:
    """See that there are enough poses for the parameters.

    One pose can fix no more combinations of parameters than the rank of its rows' derivatives.

    Raises:
        TooFewPoses: Says how many are needed.
    """
    points = model.dataset.points
    poses = np.unique(points.pose)
    sample = poses[np.unique(np.linspace(0, len(poses) - 1, min(len(poses), 20)).astype(int))]
    rows = np.flatnonzero(np.isin(points.pose, sample))
    some = model if depends_on_trajectory(model) else with_rows(model, rows)
    J = np.nan_to_num(jacobian(some, model.parameters.nominal)[:, ~box.held] * box.scale[~box.held])
    pose_of_row = np.repeat(some.dataset.points.pose, 3)
    ranks = [np.linalg.matrix_rank(J[pose_of_row == pose], rtol=RANK_TOLERANCE) for pose in sample]
    parameters = J.shape[1]
    needed = int(np.ceil(parameters / max(1.0, float(np.median(ranks)))))
    different = len(np.unique(model.dataset.flange()[poses].round(ALIKE), axis=0))
    if different < needed:
        raise TooFewPoses(len(poses), different, needed, parameters)


def check_target(model: Model) -> None:
    """See that a placed target lies in front of the camera, with the nominal parameters, for most rows.

    Raises:
        TargetUnseen: It lies behind it.
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
        raise TargetUnseen(row + HEADER, model.dataset.poses.names[pose[row]], int(behind.sum()), len(behind))
