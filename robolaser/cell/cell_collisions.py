"""Collisions in a cell: links, sensor and boxes that come too near to each other at a pose or on the way to it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.cell_config import Box, Limits
from robolaser.data.dataset import Dataset
from robolaser.geometry.collision_bodies import Body, carried_bodies, link_bodies, link_radius
from robolaser.geometry.collisions import CollisionModel
from robolaser.geometry.rigid_motion import from_quaternion, pose
from robolaser.geometry.urdf import parse

SENSOR = "the sensor"


@final
@dataclass(frozen=True)
class Collision:
    """Two bodies that a route brings too near to each other, where they are nearest.

    Attributes:
        place: Name of the pose.
        on_the_way: Whether it happens on the way there rather than at the pose itself.
        what: Both bodies.
        gap_m: Their distance; below zero, how deep they overlap [m].
        margin_m: What it should be at least [m].
    """

    place: str
    on_the_way: bool
    what: str
    gap_m: float
    margin_m: float

    def __str__(self) -> str:
        way = "on the way to " if self.on_the_way else ""
        if self.gap_m < 0:
            return f"{way}{self.place}: {self.what} overlap by {-1e3 * self.gap_m:.1f} mm"
        limit = f"{1e3 * self.margin_m:g} mm (margin_m)"
        return f"{way}{self.place}: {self.what} are {1e3 * self.gap_m:.1f} mm apart, limit {limit}"


def collision_model(description: Dataset, limits: Limits, boxes: Sequence[Box] = ()) -> CollisionModel:
    """Links, scanner and boxes of a cell.

    Args:
        description: Of robot and scanner; there is a robot.
        limits: Of the cell.
        boxes: Of the cell.
    """
    arm = description.robot
    assert arm is not None  # the caller checked it
    radius = limits.link_radius_m or link_radius(arm)
    root = parse(arm.urdf).root
    carried = carried_bodies(SENSOR, arm, tool_points(description), radius)
    stated = [
        Body(
            box.name,
            box.link or root,
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


def collisions(model: CollisionModel, margin_m: float, place: str, line: Array) -> list[Collision]:
    """Pairs of bodies nearer than a margin [m] on a straight way whose last posture is the pose itself, (s, j)."""
    gaps = model.gaps(line)
    nearest: dict[str, Collision] = {}
    for k, pair in enumerate(model.pairs):
        name, gap = model.name(pair), float(gaps[:, k].min())
        if gap < margin_m and (name not in nearest or gap < nearest[name].gap_m):  # a link may be several bodies
            nearest[name] = Collision(place, bool(gaps[-1, k] >= margin_m), name, gap, margin_m)
    return list(nearest.values())
