"""What the arm could hit, in the viewer: declared boxes, and in red the bodies that are too near to each other."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell.plan_validation import Violation, collisions
from robolaser.geometry.rigid_motion import pose
from robolaser.report.viewer.shapes import Colour, Shape, solid
from robolaser.robot.collision_bodies import Body
from robolaser.robot.collisions import CollisionModel

HIT: Colour = (214, 40, 40)
BOX: Colour = (196, 170, 120)
OPACITY = 0.7
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
            shape
            for i in sorted(red | boxes)
            for shape in _solids(f"bodies/{i}", self.model.bodies[i], T[i], is_hit=i in red)
        ]
        return "; ".join(str(hit).removeprefix("here: ") for hit in hits) or "nothing is hit", tuple(shapes)


def _solids(name: str, body: Body, T: Array, *, is_hit: bool) -> Iterator[Shape]:
    grown, colour = (SWOLLEN, HIT) if is_hit else (1.0, BOX)
    is_round = body.kind in ("cylinder", "capsule")  # grown about their axes
    size = (grown * body.size[0], body.size[1]) if is_round else tuple(grown * edge for edge in body.size)
    kind = "cylinder" if is_round else body.kind
    yield solid(name, kind, size, T, colour, OPACITY)
    if body.kind == "capsule":
        for number, side in enumerate((-0.5, 0.5)):
            end = T @ pose(np.eye(3), np.array([0.0, 0.0, side * body.size[1]]))
            yield solid(f"{name}/end_{number}", "sphere", size[:1], end, colour, OPACITY)
