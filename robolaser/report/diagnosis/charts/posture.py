"""An arm with its sensor in one pose, as points to draw lines between."""

from dataclasses import dataclass
from typing import Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.result import Diagnosis
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.effects.joints import moving_joints
from robolaser.model.forward_model import Model
from robolaser.model.sensors.sensor import motion, vector
from robolaser.model.sensors.stripe import Stripe
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values
from robolaser.report.calibration.evidence import known_points

MOST = 500  # points that a drawing carries


@final
@dataclass(frozen=True)
class Posture:
    """Places in the base frame [m].

    Attributes:
        name: Of the pose.
        joints: Names, base first.
        line: Base, joints and flange, (2 + joints, 3).
        camera: Of a scanner; of others the ball or the middle of the reflectors, (3,).
        is_scanner: Whether it is one.
        light: Projector and points where the stripe falls in this pose, (1 + k, 3); empty for other sensors.
        points: Those of target or sockets, or where the reflectors were seen, (m, 3).
    """

    name: str
    joints: tuple[str, ...]
    line: Array
    camera: Array
    is_scanner: bool
    light: Array
    points: Array

    @classmethod
    def of(cls, diagnosis: Diagnosis) -> Self:
        """The pose in the middle of those with points."""
        model = diagnosis.model
        dataset, sensor = model.dataset, model.sensor
        values = model.parameters.values(diagnosis.x[None])
        perturb = model.perturb(values)
        chosen = typical(model)
        flange = np.broadcast_to(model.flange(values, perturb)[0], (len(dataset.poses), 4, 4))[chosen]
        joints, frames = moving_joints(dataset.robot), np.empty((0, 3))
        if dataset.robot is not None and dataset.poses.q is not None:
            frames = dataset.robot.joint_frames(dataset.poses.q[None, [chosen]])[0, 0, :, :3, 3]
        points = known_points(model, values, perturb)
        if "base.x" in values:
            points = apply(inverse(motion(values, "base")[0]), points)
        light, is_scanner = np.empty((0, 3)), isinstance(sensor, Stripe)
        if isinstance(sensor, Stripe):
            mount = sensor.mount(values, perturb)[0]
            T = flange @ mount[chosen if len(mount) > 1 else 0]
            camera = T[:3, 3]
            light = np.concatenate([_projector(T, values)[None], _seen(model, values, perturb, chosen)])
        else:
            camera = apply(flange, _tools(values).mean(axis=0)[None])[0]
        return cls(
            name=dataset.poses.names[chosen],
            joints=joints,
            line=np.concatenate([np.zeros((1, 3)), frames, flange[None, :3, 3]]),
            camera=camera,
            is_scanner=is_scanner,
            light=light,
            points=points[np.linspace(0, len(points) - 1, min(MOST, len(points))).round().astype(int)],
        )


def typical(model: Model) -> int:
    """The number of the pose with points whose joints, or flange, are nearest to the median."""
    dataset = model.dataset
    seen = np.unique(dataset.points.pose)
    places = dataset.poses.q if dataset.poses.q is not None else dataset.flange()[:, :3, 3]
    away = np.linalg.norm(places[seen] - np.median(places[seen], axis=0), axis=1)
    return int(seen[np.argmin(away)])


def _projector(T_base_camera: Array, values: Values) -> Array:
    """Where the sheet cuts the camera's x axis."""
    place: Array = apply(T_base_camera, np.array([float(values["b"][0]), 0.0, 0.0]))
    return place


def _seen(model: Model, values: Values, perturb: Perturbation, pose: int) -> Array:
    """Points of the stripe in a pose, (k, 3)."""
    sensor = model.sensor
    assert isinstance(sensor, Stripe)
    rows = model.dataset.points.pose == pose
    found: Array = sensor.in_base(values, model.flange(values, perturb), perturb)[0, rows]
    return found


def _tools(values: Values) -> Array:
    """Places on the flange, (k, 3)."""
    names = dict.fromkeys(name.rpartition(".")[0] for name in values if name.startswith("tool."))
    return np.stack([vector(values, name)[0] for name in names])
