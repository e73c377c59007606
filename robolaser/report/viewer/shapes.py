"""What a scene is made of: meshes, lines and dots, each with a name and a colour."""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from robolaser.arrays import Array, Ints

Colour = tuple[int, int, int]
SIDES = 24  # of a round thing


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


Shape = Mesh | Lines | Dots


def tube(start: Array, end: Array, radius: float) -> tuple[Array, Ints]:
    """A round bar with flat ends between two points (3,), as vertices and faces."""
    x, y, _ = _beside(end - start)
    angle = np.linspace(0.0, 2 * np.pi, SIDES, endpoint=False)[:, None]
    ring = radius * (np.cos(angle) * x + np.sin(angle) * y)
    vertices = np.concatenate([start + ring, end + ring, start[None], end[None]])
    i = np.arange(SIDES)
    j = (i + 1) % SIDES
    low, high = np.full(SIDES, 2 * SIDES), np.full(SIDES, 2 * SIDES + 1)
    faces = np.concatenate(
        [
            np.column_stack([i, j, j + SIDES]),
            np.column_stack([i, j + SIDES, i + SIDES]),
            np.column_stack([j, i, low]),
            np.column_stack([i + SIDES, j + SIDES, high]),
        ]
    )
    return vertices, faces


def sphere(centre: Array, radius: float) -> tuple[Array, Ints]:
    """A sphere about a point (3,), as vertices and faces."""
    rows = SIDES // 2
    polar = np.linspace(0.0, np.pi, rows + 1)[:, None]
    turn = np.linspace(0.0, 2 * np.pi, SIDES, endpoint=False)[None]
    parts = (
        np.sin(polar) * np.cos(turn),
        np.sin(polar) * np.sin(turn),
        np.broadcast_to(np.cos(polar), (rows + 1, SIDES)),
    )
    vertices = centre + radius * np.stack(parts, axis=-1).reshape(-1, 3)
    row, i = (grid.ravel() for grid in np.meshgrid(np.arange(rows), np.arange(SIDES), indexing="ij"))
    j = (i + 1) % SIDES
    a, b, c, d = row * SIDES + i, row * SIDES + j, (row + 1) * SIDES + i, (row + 1) * SIDES + j
    return vertices, np.concatenate([np.column_stack([a, c, b]), np.column_stack([b, c, d])])


def box(T: Array, size: tuple[float, float, float]) -> tuple[Array, Ints]:
    """A box about the origin of a frame (4, 4), as vertices and faces."""
    corner = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = np.array([face for a, b, c, d in sides for face in ((a, b, c), (a, c, d))])
    return corner @ T[:3, :3].T + T[:3, 3], faces


def merged(*parts: tuple[Array, Ints]) -> tuple[Array, Ints]:
    """Several surfaces as one."""
    firsts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [faces + first for (_, faces), first in zip(parts, firsts[:-1], strict=True)]
    return np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces)


def axes(T: Array, length: float) -> tuple[Array, NDArray[np.uint8]]:
    """A frame (4, 4) as three lines in red, green and blue: ends (3, 2, 3) and colours (3, 2, 3)."""
    ends = np.stack([np.repeat(T[None, :3, 3], 3, axis=0), T[:3, 3] + length * T[:3, :3].T], axis=1)
    colours = np.array([[200, 60, 50], [60, 150, 70], [50, 90, 200]], dtype=np.uint8)
    return ends, np.repeat(colours[:, None], 2, axis=1)


def _beside(along: Array) -> tuple[Array, Array, Array]:
    """Two directions across a direction (3,), and its own; any where it has none."""
    length = float(np.linalg.norm(along))
    z = along / length if length > 0 else np.array([0.0, 0.0, 1.0])
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    return x, np.cross(z, x), z
