"""Collisions of a robot with itself and its surroundings: signed distances between bodies, by Coal."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.robot.collision_bodies import Body
from robolaser.robot.kinematics import Robot
from robolaser.robot.pinocchio_model import Link
from robolaser.robot.postures import random_configurations

NEAR = 2.0  # times the sum of their radii apart along the arm, at most: such links are built to clear themselves
TRIED = 100  # configurations all over the joints' range: two bodies that overlap in each of them are neighbours


@final
class CollisionModel:
    """The pairs of bodies that could hit each other.

    Excluded are bodies that do not move against each other, links of neighbouring joints, links known only as capsules
    within NEAR of each other along the arm, and bodies that overlap in every configuration.

    Args:
        robot: Any arm.
        bodies: On its links.
    """

    def __init__(self, robot: Robot, bodies: Sequence[Body]) -> None:
        import coal  # noqa: PLC0415 - takes long to load, with Pinocchio
        import pinocchio  # noqa: PLC0415

        self._pinocchio = pinocchio
        self.bodies = tuple(bodies)
        self._arm, self._model = robot.by_pinocchio, robot.by_pinocchio.model
        self._data, self._scene = self._model.createData(), pinocchio.GeometryModel()
        carriers, links = [], {link.name: link for link in self._arm.links}
        for number, body in enumerate(self.bodies):
            link = self._model.frames[self._model.getFrameId(body.link, pinocchio.BODY)]
            placement = link.placement * pinocchio.SE3(body.T_link_body)
            shape = _shape(coal, body)
            self._scene.addGeometryObject(pinocchio.GeometryObject(str(number), link.parentJoint, placement, shape))
            carriers.append(link.parentJoint)
        is_link = [body.name == body.link for body in self.bodies]

        def are_neighbours(i: int, j: int) -> bool:
            a, b = carriers[i], carriers[j]
            adjoining = self._model.parents[a] == b or self._model.parents[b] == a
            return a == b or (is_link[i] and is_link[j] and (adjoining or _near(links, self.bodies[i], self.bodies[j])))

        candidates = [(i, j) for i, j in combinations(range(len(self.bodies)), 2) if not are_neighbours(i, j)]
        self.pairs: tuple[tuple[int, int], ...] = ()
        self._look_at(candidates)
        always: Bools = np.all(self.gaps(random_configurations(robot, TRIED, np.random.default_rng(0))) < 0, axis=0)
        self._look_at([pair for pair, near in zip(candidates, always, strict=True) if not near])
        self.unchecked = tuple(
            (i, j)
            for (i, j), near in zip(candidates, always, strict=True)
            if near and not (is_link[i] and is_link[j]) and carriers[i] + carriers[j] > 1
        )
        """Pairs with a body that is no link, which overlap in every configuration; except the arm's support."""

    def _look_at(self, pairs: Sequence[tuple[int, int]]) -> None:
        self._scene.removeAllCollisionPairs()
        for pair in pairs:
            self._scene.addCollisionPair(self._pinocchio.CollisionPair(*pair))
        self.pairs, self._found = tuple(pairs), self._scene.createData()

    def gaps(self, q: Array) -> Array:
        """Distance of each pair at configurations (n, j), (n, pairs) [m]; below zero, the depth of their overlap."""
        gaps = np.empty((len(q), len(self.pairs)))
        for gap, row in zip(gaps, self._arm.rows(q), strict=True):
            self._pinocchio.updateGeometryPlacements(self._model, self._data, self._scene, self._found, row)
            self._pinocchio.computeDistances(self._scene, self._found)
            gap[:] = [result.min_distance for result in self._found.distanceResults]
        return gaps

    def placements(self, q: Array) -> Array:
        """T_base_body of all bodies at one configuration (j,), (bodies, 4, 4)."""
        row = self._arm.rows(q)
        self._pinocchio.updateGeometryPlacements(self._model, self._data, self._scene, self._found, row)
        return np.array([placement.homogeneous for placement in self._found.oMg]).reshape(-1, 4, 4)

    def clear(self, q: Array, margin_m: float = 0.0) -> Bools:
        """Whether no two bodies are nearer than a margin at configurations (n, j), (n,)."""
        return np.asarray(np.all(self.gaps(q) >= margin_m, axis=1))

    def name(self, pair: tuple[int, int]) -> str:
        """A pair in words."""
        return " and ".join(self.bodies[i].name for i in pair)


def _shape(coal: Any, body: Body) -> Any:
    kinds = {"box": coal.Box, "sphere": coal.Sphere, "cylinder": coal.Cylinder, "capsule": coal.Capsule}
    return kinds[body.kind](*body.size)


def _near(links: Mapping[str, Link], one: Body, other: Body) -> bool:
    """Whether one of two capsules carries the other over a short piece of the arm."""
    if not one.kind == other.kind == "capsule":
        return False
    for lower, upper in ((one, other), (other, one)):
        way, link = 0.0, links[upper.link]
        while link.parent and link.parent != lower.link:
            way += float(np.linalg.norm(link.T_parent_link[:3, 3]))
            link = links[link.parent]
        if link.parent:
            return way <= NEAR * (one.size[0] + other.size[0])
    return False
