"""What a scene is made of, each with a name and a colour, and how viser draws it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from robolaser.arrays import Array, Ints
from robolaser.geometry.rigid_motion import pose, rotation_to_axis, to_quaternion

if TYPE_CHECKING:
    from viser import SceneApi

Colour = tuple[int, int, int]


@final
@dataclass(frozen=True)
class Mesh:
    """A surface of triangles.

    Attributes:
        name: Its place in the tree of the scene.
        vertices: (n, 3) [m].
        faces: (f, 3).
        colour: Red, green, blue.
        opacity: From 0 to 1.
    """

    name: str
    vertices: Array
    faces: Ints
    colour: Colour
    opacity: float = 1.0


@final
@dataclass(frozen=True)
class Lines:
    """Straight lines.

    Attributes:
        name: Its place in the tree of the scene.
        ends: Both ends of each, (n, 2, 3) [m].
        colours: One for all, or of each end of each line, (n, 2, 3).
        width_px: On the screen.
    """

    name: str
    ends: Array
    colours: Colour | NDArray[np.uint8]
    width_px: float = 2.0


@final
@dataclass(frozen=True)
class Dots:
    """Points.

    Attributes:
        name: Its place in the tree of the scene.
        positions: (n, 3) [m].
        colours: One for all, or one for each, (n, 3).
        size_m: Of a dot.
    """

    name: str
    positions: Array
    colours: Colour | NDArray[np.uint8]
    size_m: float


@final
@dataclass(frozen=True)
class Solid:
    """A box, a sphere or a cylinder.

    Attributes:
        name: Its place in the tree of the scene.
        kind: "box", "sphere" or "cylinder".
        size: A box's edges, a sphere's (radius,), a cylinder's (radius, length along z) [m].
        T: T_base_centre, (4, 4).
        colour: Red, green, blue.
        opacity: From 0 to 1.
    """

    name: str
    kind: str
    size: tuple[float, ...]
    T: Array
    colour: Colour
    opacity: float = 1.0


Shape = Solid | Mesh | Lines | Dots


def bar(name: str, ends: tuple[Array, Array], radius: float, colour: Colour) -> Solid:
    """A round bar between two different points (3,)."""
    along = ends[1] - ends[0]
    length = float(np.linalg.norm(along))
    T = pose(rotation_to_axis(along / length), (ends[0] + ends[1]) / 2)
    return Solid(name, "cylinder", (radius, length), T, colour)


def ball(name: str, centre: Array, radius: float, colour: Colour) -> Solid:
    """A sphere about a point (3,)."""
    return Solid(name, "sphere", (radius,), pose(np.eye(3), centre), colour)


def draw(scene: "SceneApi", shape: Shape) -> Any:
    """Draw a shape, replacing any other of its name; returns viser's handle."""
    match shape:
        case Solid():
            of_kind: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
                "box": (scene.add_box, {"dimensions": shape.size}),
                "sphere": (scene.add_icosphere, {"radius": shape.size[0]}),
                "cylinder": (scene.add_cylinder, {"radius": shape.size[0], "height": shape.size[-1]}),
            }
            make, sizes = of_kind[shape.kind]
            look = {"color": shape.colour, "opacity": shape.opacity if shape.opacity < 1 else None}
            place = {"position": shape.T[:3, 3], "wxyz": np.roll(to_quaternion(shape.T[:3, :3]), 1)}
            return make(shape.name, **sizes, **look, **place)
        case Mesh():
            return scene.add_mesh_simple(
                shape.name,
                shape.vertices.astype(np.float32),
                shape.faces.astype(np.uint32),
                color=shape.colour,
                opacity=shape.opacity if shape.opacity < 1 else None,
                side="double",
                flat_shading=shape.opacity < 1,
                cast_shadow=shape.opacity == 1,
            )
        case Lines():
            return scene.add_line_segments(
                shape.name, shape.ends.astype(np.float32), shape.colours, thickness=shape.width_px,
                thickness_units="screen",
            )  # fmt: skip
        case Dots():
            return scene.add_point_cloud(
                shape.name, shape.positions.astype(np.float32), shape.colours, point_size=shape.size_m,
                point_shape="circle", precision="float32",
            )  # fmt: skip
