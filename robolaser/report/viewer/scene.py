"""The scene of a cell: its arm, scanner, light, target and points as shapes in the base frame."""

from itertools import pairwise

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.report.viewer.cell_model import CellFrames, CellModel
from robolaser.report.viewer.shapes import Colour, Dots, Lines, Mesh, Shape, axes, box, merged, sphere, tube
from robolaser.robot.collision_bodies import LEAST_RADIUS_M, MOST_RADIUS_M, SHARE_OF_ARM

ARM: Colour = (178, 186, 196)
JOINT: Colour = (88, 98, 112)
CAMERA: Colour = (38, 42, 48)
VIEW: Colour = (90, 100, 115)
LASER: Colour = (214, 40, 40)
TARGET: Colour = (60, 60, 66)
MODEL_COLOURS: dict[str, Colour] = {"nominal": (217, 112, 31), "calibrated": (43, 108, 178)}
"""Colours of the points by model, as in the pages."""

DOT = 0.006  # size of a point as a share of the extent of the target
LEAST_DOT_M, MOST_DOT_M = 2e-4, 3e-3


def moving_shapes(model: CellModel, frames: CellFrames, arm_m: float) -> tuple[Shape, ...]:
    """Shapes that move with the joints: arm, scanner and laser plane.

    Args:
        model: Of the cell.
        frames: At one pose.
        arm_m: Length of the arm, to which sizes are relative [m].
    """
    radius = float(np.clip(SHARE_OF_ARM * arm_m, LEAST_RADIUS_M, MOST_RADIUS_M))
    return (*_arm(model.dataset, frames, radius), *_scanner(frames, radius))


def fixed_shapes(model: CellModel, others: tuple[CellModel, ...]) -> tuple[Shape, ...]:
    """Shapes that do not move: the target, and the measured points by this model.

    Args:
        model: Of the cell.
        others: All models, so that their dots have one size.
    """
    known = model.target
    extent = max((float(np.ptp(one.target, axis=0).max()) for one in others if len(one.target)), default=0.0)
    size = float(np.clip(DOT * extent, LEAST_DOT_M, MOST_DOT_M))
    seen = model.points[np.isfinite(model.points).all(axis=1)]
    shapes: list[Shape] = []
    if len(known):
        shapes.append(Dots("target/points", known, TARGET, 0.8 * size))
    if len(seen):
        shapes.append(Dots("points/measured", seen, MODEL_COLOURS[model.name], size))
    return tuple(shapes)


def _arm(dataset: Dataset, frames: CellFrames, radius: float) -> list[Shape]:
    shapes: list[Shape] = []
    if len(frames.joints):
        robot, _ = dataset.arm
        points = [np.zeros(3), *frames.joints[:, :3, 3], frames.flange[:3, 3]]
        links = [
            tube(start, end, radius) for start, end in pairwise(points) if np.linalg.norm(end - start) > 0.1 * radius
        ]
        links += [sphere(point, radius) for point in points[1:-1]]
        if links:
            shapes.append(Mesh("robot/links", *merged(*links), ARM))
        turned = [T[:3, :3] @ robot.axes[i] for T, i in zip(frames.joints, robot.chain, strict=True)]
        hubs = [
            _slider(T, radius) if robot.prismatic[i] else tube(*_about(T[:3, 3], axis, 1.5 * radius), 1.25 * radius)
            for T, axis, i in zip(frames.joints, turned, robot.chain, strict=True)
        ]
        shapes.append(Mesh("robot/joints", *merged(*hubs), JOINT))
        foot = tube(np.array([0.0, 0.0, -0.3 * radius]), np.array([0.0, 0.0, 0.3 * radius]), 2.6 * radius)
        shapes.append(Mesh("robot/foot", *foot, JOINT))
    ends, colours = axes(frames.flange, 4.0 * radius)
    shapes.append(Lines("robot/flange", ends, colours, 3.0))
    return shapes


def _scanner(frames: CellFrames, radius: float) -> list[Shape]:
    T, corners, light = frames.camera, frames.corners, frames.light
    if T is None or corners is None or light is None or frames.projector is None:
        return []
    eye, lamp = T[:3, 3], frames.projector
    size = 1.1 * radius
    body = T @ _shift(0.0, 0.0, -0.8 * size)
    bracket = merged(tube(frames.flange[:3, 3], body[:3, 3], 0.3 * radius), tube(body[:3, 3], lamp, 0.3 * radius))
    shapes: list[Shape] = [
        Mesh("scanner/camera", *box(body, (size, size, 1.6 * size)), CAMERA),
        Mesh("scanner/bracket", *bracket, JOINT),
        Mesh("scanner/laser", *sphere(lamp, 0.5 * size), LASER),
        Lines("scanner/view", _frustum(eye, corners), VIEW, 1.5),
    ]
    if len(light) > 1:
        fan = np.concatenate([lamp[None], light])
        i = np.arange(1, len(light))
        faces = np.column_stack([np.zeros_like(i), i, i + 1])
        shapes.append(Mesh("light/sheet", fan, faces, LASER, 0.22))
        shapes.append(Lines("light/edge", np.stack([light[:-1], light[1:]], axis=1), LASER, 1.5))
    stripe = frames.stripe
    if stripe is not None and len(stripe) > 1:
        shapes.append(Lines("light/stripe", np.stack([stripe[:-1], stripe[1:]], axis=1), LASER, 4.0))
    return shapes


def _frustum(eye: Array, corners: Array) -> Array:
    around = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    return np.concatenate([np.stack([np.broadcast_to(eye, corners.shape), corners], axis=1), around])


def _about(point: Array, axis: Array, half: float) -> tuple[Array, Array]:
    return point - half * axis, point + half * axis


def _slider(T: Array, radius: float) -> tuple[Array, Ints]:
    return box(T, (3.0 * radius, 3.0 * radius, 3.0 * radius))


def _shift(x: float, y: float, z: float) -> Array:
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T
