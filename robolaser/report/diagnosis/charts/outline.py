"""An arm with its sensor in one pose, as points to draw lines between."""

from dataclasses import dataclass
from typing import Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.result import Diagnosis
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.effects.joints import moving_joints
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import motion, vector
from robolaser.parameters import Values
from robolaser.report.calibration.error_analysis import known_points

MOST = 500  # points that a drawing carries


@final
@dataclass(frozen=True)
class Outline:
    """Points in the base frame [m].

    Attributes:
        name: Of the pose.
        joints: Names, base first.
        line: Base, joints and flange, (2 + joints, 3).
        tip: The camera on the flange, or the middle of the points on it, (3,).
        has_camera: Whether the tip is a camera.
        light: The projector and points where the stripe falls in this pose, (1 + k, 3); empty without a laser.
        points: Those of the target or the sockets, or where the reflectors were seen, (m, 3).
    """

    name: str
    joints: tuple[str, ...]
    line: Array
    tip: Array
    has_camera: bool
    light: Array
    points: Array

    @classmethod
    def of(cls, diagnosis: Diagnosis) -> Self:
        """The pose in the middle of those with points."""
        model = diagnosis.model
        dataset = model.dataset
        values = model.parameters.values(diagnosis.x[None])
        chosen = typical(model)
        flanges = model.flange(values, model.perturb(values))[0]
        flange = np.broadcast_to(flanges, (len(dataset.poses), 4, 4))[chosen]
        frames = np.empty((0, 3))
        if dataset.robot is not None and dataset.poses.q is not None:
            frames = dataset.robot.joint_frames(dataset.poses.q[None, [chosen]])[0, 0, :, :3, 3]
        known = known_points(model, diagnosis.x)
        points = np.empty((0, 3)) if known is None else known
        if len(points):
            points = _in_base(dataset, values, points)
        camera = _camera(model, values, flange, chosen)
        return cls(
            name=dataset.poses.names[chosen],
            joints=moving_joints(dataset.robot),
            line=np.concatenate([np.zeros((1, 3)), frames, flange[None, :3, 3]]),
            tip=_on_flange(_values_at(dataset, values, chosen), flange) if camera is None else camera[:3, 3],
            has_camera=camera is not None,
            light=np.empty((0, 3)) if camera is None else _light(model, values, camera, chosen),
            points=points[np.linspace(0, len(points) - 1, min(MOST, len(points))).round().astype(int)],
        )


def typical(model: Model) -> int:
    """The number of the pose with points whose joints, or flange, are nearest to the median."""
    dataset = model.dataset
    seen = np.unique(dataset.points.pose)
    positions = dataset.poses.q if dataset.poses.q is not None else dataset.flange()[:, :3, 3]
    away = np.linalg.norm(positions[seen] - np.median(positions[seen], axis=0), axis=1)
    return int(seen[np.argmin(away)])


def _values_at(dataset: Dataset, values: Values, pose: int) -> Values:
    """Values by the names that they have without sessions, as in the session of a pose."""
    sessions, of_pose = dataset.sessions, dataset.poses.session
    return values if sessions is None or of_pose is None else sessions.values_in(values, of_pose[pose])


def _in_base(dataset: Dataset, values: Values, points: Array) -> Array:
    """Points (m, 3) of rows in the base frame, where a tracker saw them in its own."""
    placed, of_pose = points.copy(), dataset.points.pose
    session = dataset.session_of_pose[of_pose]
    for rows in (session == number for number in np.unique(session)):
        own = _values_at(dataset, values, int(of_pose[rows][0]))
        if "base.x" in own:
            placed[rows] = apply(inverse(motion(own, "base")[0]), points[rows])
    return placed


def _camera(model: Model, values: Values, T_base_flange: Array, pose: int) -> Array | None:
    """T_base_camera of a camera on the flange, (4, 4)."""
    mount = model.sensor.mount(values, model.perturb(values))
    if mount is not None:
        T_flange_camera = mount[0, pose if mount.shape[1] > 1 else 0]
    elif "hand_eye.x" in values:
        T_flange_camera = motion(values, "hand_eye")[0]
    else:
        return None
    placed: Array = T_base_flange @ T_flange_camera
    return placed


def _light(model: Model, values: Values, T_base_camera: Array, pose: int) -> Array:
    """Where the laser plane meets the camera's x axis, and where the stripe falls in a pose, (1 + k, 3)."""
    perturb = model.perturb(values)
    seen = model.sensor.in_base(values, model.flange(values, perturb), perturb)
    if seen is None or not model.sensor.has_laser_plane():
        return np.empty((0, 3))
    projector = apply(T_base_camera, np.array([[float(values["b"][0]), 0.0, 0.0]]))
    return np.concatenate([projector, seen[0, model.dataset.points.pose == pose]])


def _on_flange(values: Values, T_base_flange: Array) -> Array:
    """The middle of the points on the flange, or the flange itself, (3,)."""
    names = dict.fromkeys(name.rpartition(".")[0] for name in values if name.startswith("tool."))
    tools = [vector(values, name)[0] for name in names] or [np.zeros(3)]
    middle: Array = apply(T_base_flange, np.mean(tools, axis=0)[None])[0]
    return middle
