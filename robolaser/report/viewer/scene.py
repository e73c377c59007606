"""The scene of a cell as viser draws it: arm, scanner, light, target, points, clouds, and obstacles."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from robolaser.arrays import Array
from robolaser.cell.plan_validation import collisions
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import pose, rotation_to_axis, to_quaternion
from robolaser.report.cell_poses import CellFrames, CellPoses
from robolaser.report.viewer.cells import ArmAlone
from robolaser.robot.collision_bodies import Body, link_radius
from robolaser.robot.collisions import CollisionModel
from robolaser.scan.ply import Vertices, positions_of

if TYPE_CHECKING:
    from viser import SceneApi

ShownCell = CellPoses | ArmAlone  # a cell by a model, as the viewer shows it
Colour = tuple[int, int, int]
Colours = Colour | NDArray[np.uint8]

ARM: Colour = (178, 186, 196)
JOINT: Colour = (88, 98, 112)
CAMERA: Colour = (38, 42, 48)
VIEW: Colour = (90, 100, 115)
LASER: Colour = (214, 40, 40)
HIT = LASER
BOX: Colour = (196, 170, 120)
TARGET: Colour = (60, 60, 66)
MODEL_COLOURS: dict[str, Colour] = {"nominal": (217, 112, 31), "calibrated": (43, 108, 178)}  # of points, as in pages
AXES = np.array([[200, 60, 50], [60, 150, 70], [50, 90, 200]], dtype=np.uint8)
OPACITY = 0.7
SWOLLEN = 1.04  # red bodies are shown so much thicker, so that the drawn arm does not hide them

DOT = 0.006  # size of a point as a share of the extent of the target
LEAST_DOT_M, MOST_DOT_M = 2e-4, 3e-3
MOST = 1_000_000  # points of a cloud: a browser still turns them smoothly, and loads them within a second
CLEAR = 1.0, 99.0  # percentiles between which colours are spread: a stray point would use up the range
SPACING = 0.6  # size of a dot over the distance to its neighbours: a surface looks closed, its texture is still visible
LEAST_M, MOST_M = 1e-4, 3e-3  # sizes of a cloud's dots: smaller ones are invisible, larger ones hide edges


@final
@dataclass(frozen=True, eq=False)
class SceneNode:
    """A thing in the scene."""

    name: str  # its place in the tree of the scene
    kind: str  # viser's name of it, as `box` of `add_box`
    look: Mapping[str, Any]  # viser's arguments

    def draw(self, scene: "SceneApi") -> Any:
        """Draw it, replacing any other of its name; returns viser's handle."""
        return getattr(scene, f"add_{self.kind}")(self.name, **self.look)


def moving_shapes(model: ShownCell, frames: CellFrames) -> tuple[SceneNode, ...]:
    """Shapes that move with the joints, at one pose: arm, scanner and laser plane."""
    radius = link_radius(model.dataset.robot)
    return (*_arm(model.dataset, frames, radius), *_scanner(frames, radius))


def fixed_shapes(model: ShownCell, others: tuple[ShownCell, ...]) -> tuple[SceneNode, ...]:
    """Fixed shapes: the target, and the measured points by this model; dots of all models have one size."""
    extent = max((float(np.ptp(one.target, axis=0).max()) for one in others if len(one.target)), default=0.0)
    size = float(np.clip(DOT * extent, LEAST_DOT_M, MOST_DOT_M))
    seen = model.points[np.isfinite(model.points).all(axis=1)]
    target = dots("target/points", model.target, TARGET, 0.8 * size)
    measured = dots("points/measured", seen, MODEL_COLOURS[model.name], size)
    return (target,) * bool(len(model.target)) + (measured,) * bool(len(seen))


def collision_shapes(model: CollisionModel, margin_m: float, q: Array) -> tuple[str, tuple[SceneNode, ...]]:
    """Bodies nearer to each other than a margin [m] at joint values (j,), in words, and the shapes to show there."""
    hits = [what for _, what in collisions(model, margin_m, q[None])]
    red = {i for k in np.flatnonzero(model.gaps(q[None])[0] < margin_m) for i in model.pairs[k]}
    boxes = {i for i, body in enumerate(model.bodies) if body.kind == "box" and body.name != body.link}
    T = model.placements(q)
    shapes = (_solids(f"bodies/{i}", model.bodies[i], T[i], is_hit=i in red) for i in sorted(red | boxes))
    return "; ".join(hits) or "nothing is hit", tuple(shape for some in shapes for shape in some)


def downsampled(vertices: Vertices, most: int = MOST) -> SceneNode | None:
    """Evenly spaced points of a cloud; None where it has none."""
    every = max(1, -(-len(vertices) // most))
    positions = positions_of(vertices[::every])
    if not len(positions):
        return None
    low, high = np.percentile(positions, CLEAR, axis=0)
    sides = np.sort(high - low)[1:]
    size = SPACING * float(np.sqrt(sides.prod() / len(positions)))
    return dots("cloud", positions, by_height(positions[:, 2], low[2], high[2]), float(np.clip(size, LEAST_M, MOST_M)))


def by_height(z: Array, low: float, high: float) -> NDArray[np.uint8]:
    """Colours from blue over green to yellow, as charts of clouds have them, (n,) -> (n, 3)."""
    import cv2  # noqa: PLC0415 - slow to import

    share = np.clip((z - low) / (high - low if high > low else 1.0), 0.0, 1.0)
    levels = (255 * share).round().astype(np.uint8)
    return np.ascontiguousarray(cv2.applyColorMap(levels[:, None], cv2.COLORMAP_VIRIDIS)[:, 0, ::-1], np.uint8)


def _arm(dataset: Dataset, frames: CellFrames, radius: float) -> Iterator[SceneNode]:
    if len(frames.joints):
        robot, _ = dataset.arm
        points = [np.zeros(3), *frames.joints[:, :3, 3], frames.flange[:3, 3]]
        for number, (start, end) in enumerate(pairwise(points)):
            if np.linalg.norm(end - start) > 0.1 * radius:
                yield bar(f"robot/link_{number}", (start, end), radius, ARM)
        yield from (_ball(f"robot/corner_{i}", point, radius, ARM) for i, point in enumerate(points[1:-1]))
        for T, i in zip(frames.joints, robot.chain, strict=True):
            name, across = f"robot/{robot.joints[i]}", 1.5 * radius * T[:3, :3] @ robot.axes[i]
            if robot.prismatic[i]:
                yield _solid(name, "box", (3.0 * radius,) * 3, T, JOINT)
            else:
                yield bar(name, (T[:3, 3] - across, T[:3, 3] + across), 1.25 * radius, JOINT)
        yield _solid("robot/foot", "cylinder", (2.6 * radius, 0.6 * radius), np.eye(4), JOINT)
    ends = np.stack([np.repeat(frames.flange[None, :3, 3], 3, axis=0),
                     frames.flange[:3, 3] + 4.0 * radius * frames.flange[:3, :3].T], axis=1)  # fmt: skip
    yield _lines("robot/flange", ends, np.repeat(AXES[:, None], 2, axis=1), 3.0)


def _scanner(frames: CellFrames, radius: float) -> Iterator[SceneNode]:
    T, corners, light = frames.camera, frames.corners, frames.light
    if T is None or corners is None:
        return
    size = 1.1 * radius
    body = T @ pose(np.eye(3), np.array([0.0, 0.0, -0.8 * size]))
    yield _solid("sensor/camera", "box", (size, size, 1.6 * size), body, CAMERA)
    for name, end in (("sensor/bracket", frames.flange[:3, 3]), *(("sensor/arm", at) for at in light[:1])):
        if np.linalg.norm(end - body[:3, 3]) > 0.0:
            yield bar(name, (body[:3, 3], end), 0.3 * radius, JOINT)
    edges = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    rays = np.stack([np.broadcast_to(T[:3, 3], corners.shape), corners], axis=1)
    yield _lines("sensor/view", np.concatenate([rays, edges]), VIEW, 1.5)
    yield from (_ball("sensor/laser", at, 0.5 * size, LASER) for at in light[:1])
    if len(light) > 2:
        i = np.arange(1, len(light) - 1)
        faces = np.column_stack([np.zeros_like(i), i, i + 1]).astype(np.uint32)
        look = {"vertices": light.astype(np.float32), "faces": faces, "color": LASER, "opacity": 0.22}
        more = {"side": "double", "flat_shading": True, "cast_shadow": False}
        yield SceneNode("light/sheet", "mesh_simple", {**look, **more})
        yield _lines("light/stripe", np.stack([light[1:-1], light[2:]], axis=1), LASER, 4.0)


def _solids(name: str, body: Body, T: Array, *, is_hit: bool) -> Iterator[SceneNode]:
    grown, colour = (SWOLLEN, HIT) if is_hit else (1.0, BOX)
    is_round = body.kind in ("cylinder", "capsule")  # grown about their axes
    size = (grown * body.size[0], body.size[1]) if is_round else tuple(grown * edge for edge in body.size)
    yield _solid(name, "cylinder" if is_round else body.kind, size, T, colour, OPACITY)
    for number, side in enumerate((-0.5, 0.5) if body.kind == "capsule" else ()):
        end = T @ pose(np.eye(3), np.array([0.0, 0.0, side * body.size[1]]))
        yield _solid(f"{name}/end_{number}", "sphere", size[:1], end, colour, OPACITY)


def _solid(name: str, kind: str, size: tuple[float, ...], T: Array, colour: Colour, opacity: float = 1.0) -> SceneNode:
    """A box, a sphere or a cylinder at T_base_centre, (4, 4): its edges, (radius,), or (radius, length along z) [m]."""
    of_kind: dict[str, tuple[str, dict[str, Any]]] = {
        "box": ("box", {"dimensions": size}),
        "sphere": ("icosphere", {"radius": size[0]}),
        "cylinder": ("cylinder", {"radius": size[0], "height": size[-1]}),
    }
    drawn, sizes = of_kind[kind]
    placement = {"position": T[:3, 3], "wxyz": np.roll(to_quaternion(T[:3, :3]), 1)}
    return SceneNode(name, drawn, {**sizes, **placement, "color": colour, "opacity": opacity if opacity < 1 else None})


def bar(name: str, ends: tuple[Array, Array], radius: float, colour: Colour) -> SceneNode:
    """A round bar between two different points (3,)."""
    along = ends[1] - ends[0]
    length = float(np.linalg.norm(along))
    T = pose(rotation_to_axis(along / length), (ends[0] + ends[1]) / 2)
    return _solid(name, "cylinder", (radius, length), T, colour)


def _ball(name: str, centre: Array, radius: float, colour: Colour) -> SceneNode:
    return _solid(name, "sphere", (radius,), pose(np.eye(3), centre), colour)


def _lines(name: str, ends: Array, colours: Colours, width_px: float) -> SceneNode:
    """Straight lines between both ends of each, (n, 2, 3), of one colour or one of each end, (n, 2, 3)."""
    look = {"points": ends.astype(np.float32), "colors": colours}
    return SceneNode(name, "line_segments", {**look, "thickness": width_px, "thickness_units": "screen"})


def dots(name: str, positions: Array, colours: Colours, size_m: float) -> SceneNode:
    """Points (n, 3) of one colour, or one each, (n, 3)."""
    look = {"points": positions.astype(np.float32), "colors": colours, "point_size": size_m}
    return SceneNode(name, "point_cloud", {**look, "point_shape": "circle", "precision": "float32"})
