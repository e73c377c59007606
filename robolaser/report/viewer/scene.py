"""The scene of a cell: arm, scanner, light, target and points, and what the arm could hit, as shapes in one frame."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell.plan_validation import collisions
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import pose
from robolaser.report.cell_poses import CellFrames, CellPoses
from robolaser.report.viewer.cells import ArmAlone
from robolaser.report.viewer.shapes import Colour, SceneNode, ball, bar, dots, lines, sheet, solid
from robolaser.robot.collision_bodies import Body, link_radius
from robolaser.robot.collisions import CollisionModel

ShownCell = CellPoses | ArmAlone  # a cell by a model, as the viewer shows it

ARM: Colour = (178, 186, 196)
JOINT: Colour = (88, 98, 112)
CAMERA: Colour = (38, 42, 48)
VIEW: Colour = (90, 100, 115)
LASER: Colour = (214, 40, 40)
HIT = LASER
TARGET: Colour = (60, 60, 66)
MODEL_COLOURS: dict[str, Colour] = {"nominal": (217, 112, 31), "calibrated": (43, 108, 178)}
"""Colours of the points by model, as in the pages."""
AXES = np.array([[200, 60, 50], [60, 150, 70], [50, 90, 200]], dtype=np.uint8)

DOT = 0.006  # size of a point as a share of the extent of the target
LEAST_DOT_M, MOST_DOT_M = 2e-4, 3e-3


def moving_shapes(model: ShownCell, frames: CellFrames) -> tuple[SceneNode, ...]:
    """Shapes that move with the joints: arm, scanner and laser plane.

    Args:
        model: Of the cell.
        frames: At one pose.
    """
    radius = link_radius(model.dataset.robot)
    return (*_arm(model.dataset, frames, radius), *_scanner(frames, radius))


def fixed_shapes(model: ShownCell, others: tuple[ShownCell, ...]) -> tuple[SceneNode, ...]:
    """Shapes that do not move: the target, and the measured points by this model.

    Args:
        model: Of the cell.
        others: All models, so that their dots have one size.
    """
    known = model.target
    extent = max((float(np.ptp(one.target, axis=0).max()) for one in others if len(one.target)), default=0.0)
    size = float(np.clip(DOT * extent, LEAST_DOT_M, MOST_DOT_M))
    seen = model.points[np.isfinite(model.points).all(axis=1)]
    shapes: list[SceneNode] = []
    if len(known):
        shapes.append(dots("target/points", known, TARGET, 0.8 * size))
    if len(seen):
        shapes.append(dots("points/measured", seen, MODEL_COLOURS[model.name], size))
    return tuple(shapes)


def _arm(dataset: Dataset, frames: CellFrames, radius: float) -> list[SceneNode]:
    shapes: list[SceneNode] = []
    if len(frames.joints):
        robot, _ = dataset.arm
        points = [np.zeros(3), *frames.joints[:, :3, 3], frames.flange[:3, 3]]
        for number, (start, end) in enumerate(pairwise(points)):
            if np.linalg.norm(end - start) > 0.1 * radius:
                shapes.append(bar(f"robot/link_{number}", (start, end), radius, ARM))
        shapes += [ball(f"robot/corner_{i}", point, radius, ARM) for i, point in enumerate(points[1:-1])]
        for T, i in zip(frames.joints, robot.chain, strict=True):
            name, across = f"robot/{robot.joints[i]}", 1.5 * radius * T[:3, :3] @ robot.axes[i]
            hub = T[:3, 3] - across, T[:3, 3] + across
            shapes.append(
                solid(name, "box", (3.0 * radius,) * 3, T, JOINT)
                if robot.prismatic[i]
                else bar(name, hub, 1.25 * radius, JOINT)
            )
        shapes.append(solid("robot/foot", "cylinder", (2.6 * radius, 0.6 * radius), np.eye(4), JOINT))
    ends = np.stack([np.repeat(frames.flange[None, :3, 3], 3, axis=0),
                     frames.flange[:3, 3] + 4.0 * radius * frames.flange[:3, :3].T], axis=1)  # fmt: skip
    shapes.append(lines("robot/flange", ends, np.repeat(AXES[:, None], 2, axis=1), 3.0))
    return shapes


def _scanner(frames: CellFrames, radius: float) -> list[SceneNode]:
    T, corners, light = frames.camera, frames.corners, frames.light
    if T is None or corners is None:
        return []
    eye = T[:3, 3]
    size = 1.1 * radius
    body = T @ pose(np.eye(3), np.array([0.0, 0.0, -0.8 * size]))
    held = {"sensor/bracket": frames.flange[:3, 3]} | ({"sensor/arm": light[0]} if len(light) else {})
    shapes: list[SceneNode] = [
        solid("sensor/camera", "box", (size, size, 1.6 * size), body, CAMERA),
        *(bar(name, (body[:3, 3], end), 0.3 * radius, JOINT) for name, end in held.items()
          if np.linalg.norm(end - body[:3, 3]) > 0.0),
        lines("sensor/view", _frustum(eye, corners), VIEW, 1.5),
    ]  # fmt: skip
    if len(light):
        shapes.append(ball("sensor/laser", light[0], 0.5 * size, LASER))
    if len(light) > 2:
        i = np.arange(1, len(light) - 1)
        shapes.append(sheet("light/sheet", light, np.column_stack([np.zeros_like(i), i, i + 1]), LASER, 0.22))
        shapes.append(lines("light/stripe", np.stack([light[1:-1], light[2:]], axis=1), LASER, 4.0))
    return shapes


def _frustum(eye: Array, corners: Array) -> Array:
    around = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    return np.concatenate([np.stack([np.broadcast_to(eye, corners.shape), corners], axis=1), around])


BOX: Colour = (196, 170, 120)
OPACITY = 0.7
SWOLLEN = 1.04  # red bodies are shown so much thicker, lest the arm that is drawn hides them


@final
@dataclass(frozen=True)
class CollisionScene:
    """Bodies of a cell."""

    model: CollisionModel  # links, sensor and boxes
    margin_m: float  # least distance that they should keep [m]

    def at(self, q: Array) -> tuple[str, tuple[SceneNode, ...]]:
        """What is too near to what at one configuration (j,), in words, and the shapes to be shown there."""
        hits = [what for _, what in collisions(self.model, self.margin_m, q[None])]
        near = np.flatnonzero(self.model.gaps(q[None])[0] < self.margin_m)
        red = {i for k in near for i in self.model.pairs[k]}
        boxes = {i for i, body in enumerate(self.model.bodies) if body.kind == "box" and body.name != body.link}
        T = self.model.placements(q)
        shapes = [
            shape
            for i in sorted(red | boxes)
            for shape in _solids(f"bodies/{i}", self.model.bodies[i], T[i], is_hit=i in red)
        ]
        return "; ".join(hits) or "nothing is hit", tuple(shapes)


def _solids(name: str, body: Body, T: Array, *, is_hit: bool) -> Iterator[SceneNode]:
    grown, colour = (SWOLLEN, HIT) if is_hit else (1.0, BOX)
    is_round = body.kind in ("cylinder", "capsule")  # grown about their axes
    size = (grown * body.size[0], body.size[1]) if is_round else tuple(grown * edge for edge in body.size)
    kind = "cylinder" if is_round else body.kind
    yield solid(name, kind, size, T, colour, OPACITY)
    if body.kind == "capsule":
        for number, side in enumerate((-0.5, 0.5)):
            end = T @ pose(np.eye(3), np.array([0.0, 0.0, side * body.size[1]]))
            yield solid(f"{name}/end_{number}", "sphere", size[:1], end, colour, OPACITY)
