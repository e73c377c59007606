"""What could collide in a cell: links, sensor and boxes."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.data.cell_config import Box, Limits
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import from_quaternion, pose
from robolaser.robot.collision_bodies import Body, carried_bodies, link_bodies, link_radius
from robolaser.robot.collisions import CollisionModel

SENSOR = "the sensor"


def collision_model(description: Dataset, limits: Limits, boxes: Sequence[Box] = ()) -> CollisionModel:
    """Links, scanner and boxes of a cell, which has a robot."""
    arm = description.robot
    assert arm is not None  # the caller checked it
    radius = limits.link_radius_m or link_radius(arm)
    carried = carried_bodies(SENSOR, arm, tool_points(description), radius)
    stated = [
        Body(
            box.name,
            box.link or arm.base,
            "box",
            box.size_m,
            pose(from_quaternion(np.array(box.quat)), np.array(box.centre_m)),
        )
        for box in boxes
    ]
    return CollisionModel(arm, [*link_bodies(arm, radius), *carried, *stated])


def tool_points(description: Dataset) -> Array:
    """Camera and light projector in the flange frame, by their drawing, (2, 3) [m]; none where nothing is drawn."""
    drawn = description.parameters
    if not {"t_x", "t_y", "t_z", "b"} <= drawn.keys():
        return np.empty((0, 3))
    camera = np.array([drawn[name].nominal for name in ("t_x", "t_y", "t_z")])
    R = from_quaternion(np.array(description.bracket_quat))
    return np.stack([camera, camera + R @ np.array([drawn["b"].nominal, 0.0, 0.0])])
