"""What a scene is made of: shapes by name, each with what viser takes to draw it, in metres; clouds as dots."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from robolaser.arrays import Array, Ints
from robolaser.geometry.rigid_motion import pose, rotation_to_axis, to_quaternion
from robolaser.scan.ply import Vertices, positions_of

if TYPE_CHECKING:
    from viser import SceneApi

Colour = tuple[int, int, int]
Colours = Colour | NDArray[np.uint8]


@final
@dataclass(frozen=True, eq=False)
class SceneNode:
    """A thing in the scene."""

    name: str  # its place in the tree of the scene
    kind: str  # which of viser's things it is, as `box` of `add_box`
    look: Mapping[str, Any]  # what viser takes for it


def draw(scene: "SceneApi", shape: SceneNode) -> Any:
    """Draw a shape, replacing any other of its name; returns viser's handle."""
    return getattr(scene, f"add_{shape.kind}")(shape.name, **shape.look)


def solid(name: str, kind: str, size: tuple[float, ...], T: Array, colour: Colour, opacity: float = 1.0) -> SceneNode:
    """A box, a sphere or a cylinder at T_base_centre, (4, 4).

    Args:
        name: Its place in the tree of the scene.
        kind: "box", "sphere" or "cylinder".
        size: A box's edges, a sphere's (radius,), a cylinder's (radius, length along z) [m].
        T: Where it is.
        colour: Red, green, blue.
        opacity: From 0 to 1.
    """
    of_kind: dict[str, tuple[str, dict[str, Any]]] = {
        "box": ("box", {"dimensions": size}),
        "sphere": ("icosphere", {"radius": size[0]}),
        "cylinder": ("cylinder", {"radius": size[0], "height": size[-1]}),
    }
    drawn, sizes = of_kind[kind]
    place = {"position": T[:3, 3], "wxyz": np.roll(to_quaternion(T[:3, :3]), 1)}
    return SceneNode(name, drawn, {**sizes, **place, "color": colour, "opacity": opacity if opacity < 1 else None})


def bar(name: str, ends: tuple[Array, Array], radius: float, colour: Colour) -> SceneNode:
    """A round bar between two different points (3,)."""
    along = ends[1] - ends[0]
    length = float(np.linalg.norm(along))
    T = pose(rotation_to_axis(along / length), (ends[0] + ends[1]) / 2)
    return solid(name, "cylinder", (radius, length), T, colour)


def ball(name: str, centre: Array, radius: float, colour: Colour) -> SceneNode:
    """A sphere about a point (3,)."""
    return solid(name, "sphere", (radius,), pose(np.eye(3), centre), colour)


def sheet(name: str, vertices: Array, faces: Ints, colour: Colour, opacity: float) -> SceneNode:
    """A surface of triangles that one sees through: points (n, 3), and the three of each triangle (f, 3)."""
    look = {"vertices": vertices.astype(np.float32), "faces": faces.astype(np.uint32), "color": colour}
    more = {"opacity": opacity, "side": "double", "flat_shading": True, "cast_shadow": False}
    return SceneNode(name, "mesh_simple", {**look, **more})


def lines(name: str, ends: Array, colours: Colours, width_px: float) -> SceneNode:
    """Straight lines between both ends of each, (n, 2, 3), of one colour or one of each end, (n, 2, 3)."""
    look = {"points": ends.astype(np.float32), "colors": colours}
    return SceneNode(name, "line_segments", {**look, "thickness": width_px, "thickness_units": "screen"})


def dots(name: str, positions: Array, colours: Colours, size_m: float) -> SceneNode:
    """Points (n, 3) of one colour, or one each, (n, 3)."""
    look = {"points": positions.astype(np.float32), "colors": colours, "point_size": size_m}
    return SceneNode(name, "point_cloud", {**look, "point_shape": "circle", "precision": "float32"})


MOST = 1_000_000  # points: a browser still turns them smoothly, and gets them within a second
CLEAR = 1.0, 99.0  # percentiles between which colours are spread: a stray point would take them all
SPACING = 0.6  # size of a dot over the distance to its neighbours: a surface looks closed, its grain still shows
LEAST_M, MOST_M = 1e-4, 3e-3  # sizes of dots: smaller ones are not seen, larger ones hide edges


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
