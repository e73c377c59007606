"""What the arm could hit, in the viewer: declared boxes, and in red the bodies that are too near to each other."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.cell.plan_validation import Violation, collisions
from robolaser.report.viewer.shapes import Colour, Mesh, Shape, box, merged, sphere, tube
from robolaser.robot.collision_bodies import Body
from robolaser.robot.collisions import CollisionModel

HIT: Colour = (214, 40, 40)
BOX: Colour = (196, 170, 120)
MOST_SHOWN = 8  # lines of the panel
SWOLLEN = 1.04  # red bodies are shown so much thicker, lest the arm that is drawn hides them


@final
@dataclass(frozen=True)
class CollisionScene:
    """Bodies of a cell.

    Attributes:
        model: Links, sensor and boxes.
        margin_m: Least distance that they should keep [m].
        route: What the poses that are shown would break, and the ways between them.
    """

    model: CollisionModel
    margin_m: float
    route: tuple[Violation, ...]

    @property
    def route_note(self) -> str:
        """Of all poses, for the panel."""
        if not self.route:
            return "Nothing is hit at these poses, nor on the way between them."
        more = len(self.route) - MOST_SHOWN
        lines = [f"* {one}" for one in self.route[:MOST_SHOWN]] + [f"* ... and {more} more"] * (more > 0)
        return "\n".join(lines)

    def at(self, q: Array) -> tuple[str, tuple[Shape, ...]]:
        """What is too near to what at one configuration (j,), in words, and the shapes to be shown there."""
        hits = collisions(self.model, self.margin_m, "here", q[None])
        near = np.flatnonzero(self.model.gaps(q[None])[0] < self.margin_m)
        red = {i for k in near for i in self.model.pairs[k]}
        boxes = {i for i, body in enumerate(self.model.bodies) if body.kind == "box" and body.name != body.link}
        T = self.model.placements(q)
        shapes = [
            Mesh(f"bodies/{i}", *_surface(self.model.bodies[i], T[i], swollen=i in red), HIT if i in red else BOX, 0.7)
            for i in sorted(red | boxes)
        ]
        return "; ".join(str(hit).removeprefix("here: ") for hit in hits) or "nothing is hit", tuple(shapes)


def _surface(body: Body, T: Array, *, swollen: bool) -> tuple[Array, Ints]:
    grown = SWOLLEN if swollen else 1.0
    if body.kind == "box":
        x, y, z = (grown * edge for edge in body.size)
        return box(T, (x, y, z))
    radius = grown * body.size[0]
    if body.kind == "sphere":
        return sphere(T[:3, 3], radius)
    half = 0.5 * body.size[1] * T[:3, 2]
    ends = T[:3, 3] - half, T[:3, 3] + half
    bar = tube(*ends, radius)
    return bar if body.kind == "cylinder" else merged(bar, *(sphere(end, radius) for end in ends))
