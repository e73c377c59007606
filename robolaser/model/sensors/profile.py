"""A laser profile sensor that measures balls of known radius."""

from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.sensor_format import SensorFormat
from robolaser.data.subsampling import evenly
from robolaser.errors import EstimationError
from robolaser.geometry.rigid_motion import apply, carry, inverse, pose
from robolaser.model.error_source import ErrorSource
from robolaser.model.grouped_rows import group_sums
from robolaser.model.sensors.in_cell import InCell, Mounting, is_static
from robolaser.model.sensors.placements import motion, places, places_by_name, six_names, six_of
from robolaser.model.sensors.sensor import NewPoses, Perturbation, Sensor, SensorParameters, Stage, Values
from robolaser.model.sensors.tracker_fit import base_and_tools

ENOUGH_PROFILES = 600  # profiles for start values
ROUNDS = 20  # alternations between sides and positions from each start
GUESSES = 4  # random guesses of the sides, besides balls cut through their middle
LEAST_ROWS = 3  # points of a profile on a ball: a circle has three numbers
ARC = np.radians(60.0)  # half the arc of a ball that a sensor sees
MOST_CUT = 0.75
"""Distance of a ball's middle from the profile's plane, over its radius, up to which the ball is seen well."""
ROWS = 24  # of a profile that would be seen


@final
class Profile(Sensor):
    """Points (x, 0, z) of a profile are on the ball: their distance from its centre is its radius.

    That distance less the radius is a row's one number. An isotropic error of a point moves it by the part of the
    ball's normal in the profile's plane: where the plane cuts the ball near its rim, rows weigh more. So the fit of
    rows weighted by their noise has the greatest likelihood, to first order in the noise over the radius.
    """

    format: ClassVar[SensorFormat] = SensorFormat(
        kind="profile",
        title="profile sensor",
        columns={"profile": ("x_m", "z_m")},
        absent={"y_m": "a profile is in the sensor's plane y = 0"},
        numbers=1,
        options=Mounting,
        many_rows=True,
        balls=True,
        units={"radius": "m"},
        task="the model puts profiles on balls",
        named_points="ball",
    )
    stages: ClassVar[frozenset[Stage]] = Sensor.stages | {Stage.MOUNT, Stage.TARGET}

    def __init__(self, dataset: Dataset) -> None:
        super().__init__(dataset)
        self._measured = np.insert(dataset.points["profile"], 1, 0.0, axis=1)[None]
        self.ball = dataset.points.number  # which of them each row is on, (m,)
        self.is_static = is_static(dataset)  # in the cell

    @cached_property
    def parameters(self) -> SensorParameters:
        """The sensor's placement on the flange or in the cell, the balls at the other end, and unknown radii."""
        balls = (f"ball.{name}.{part}" for name in self.names for part in "xyz")
        radii = () if self.dataset.radius_m else tuple(map(_radius, self.names))
        return SensorParameters(
            derived=(*six_names("hand_eye"), *balls, *radii),
            spans=lambda values: {name: 0.5 * values[name] for name in radii},
            two_axes=True,
        )

    def _radii(self, values: Values) -> Array:
        """Of each ball, (1 or c, balls) [m]: stated, or among the values."""
        stated = self.dataset.radius_m
        if stated:
            return np.array([[stated[name] for name in self.names]])
        return np.stack([values[_radius(name)] for name in self.names], axis=-1)

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """From the circles in which the sensor's plane cuts the balls; the largest determine unstated radii.

        Raises:
            EstimationError: A ball is in no profile of enough points.
        """
        seen = perturb(Stage.TARGET, self._measured)
        of_pose = self.dataset.points.pose
        _, first, profile = np.unique(of_pose * len(self.names) + self.ball, return_index=True, return_inverse=True)
        found = []
        for candidate in range(max(len(seen), len(T_base_flange))):
            centre, radius, enough = circles(seen[candidate % len(seen)][:, ::2], profile.reshape(-1))
            some = np.flatnonzero(enough)
            self._check_seen(self.ball[first[some]])
            some = some[evenly(len(some), ENOUGH_PROFILES)]
            ball, cut = self.ball[first[some]], radius[some]
            radii = self._radii({_radius(name): _of_largest(cut[ball == i]) for i, name in enumerate(self.names)})[0]
            beside = np.sqrt(np.maximum(radii[ball] ** 2 - cut**2, 0.0))
            T = T_base_flange[candidate % len(T_base_flange)][of_pose[first[some]]]
            T = T if self.is_static else inverse(T)
            found.append((*sensor_and_balls(centre[some], beside, T, ball), radii))
        R, shift, balls, radii = (np.stack(parts) for parts in zip(*found, strict=True))
        sizes = dict(zip(map(_radius, self.names), radii.T, strict=True))
        return six_of(inverse(pose(R, shift)), "hand_eye") | places_by_name(balls, "ball", self.names) | sizes

    def _check_seen(self, balls: Ints) -> None:
        """Check that each ball has a profile with a circle.

        Raises:
            EstimationError: One has none.
        """
        unseen = [name for number, name in enumerate(self.names) if number not in balls]
        if unseen:
            raise EstimationError(
                f"No profile of ball {', '.join(unseen)} has {LEAST_ROWS} points or more, from which its centre could"
                " be found. Add the other points of the profiles to points.csv, or delete the rows on this ball."
            )

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Distance of each point from its ball's surface, positive outside, (c, m, 1) [m]."""
        apart = self.in_base(values, T_base_flange, perturb) - self.known(values, T_base_flange, perturb)
        off: Array = np.linalg.norm(apart, axis=-1) - self._radii(values)[:, self.ball]
        return off[..., None]

    def in_metres(self, residuals: Array, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Along the ball's normals in the base frame, towards its middle, (c, m, 3) [m]."""
        return -residuals * self._normals(values, T_base_flange, perturb)

    def in_base(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The points of the profiles, in the base frame, (c, m, 3) [m]."""
        T_base_sensor = self._sensor_in_base(values, T_base_flange, perturb)
        return carry(T_base_sensor, self.dataset.points.pose, perturb(Stage.TARGET, self._measured))

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The middles of the balls, in the base frame, (c, m, 3) [m]."""
        balls = places(values, "ball", self.names)[:, self.ball]
        return carry(T_base_flange, self.dataset.points.pose, balls) if self.is_static else balls

    def _mount(self, values: Values, perturb: Perturbation) -> Array:
        return perturb(Stage.MOUNT, motion(values, "hand_eye")[:, None])

    def _normals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The ball's normal at each point, in the base frame, (c, m, 3)."""
        apart = self.in_base(values, T_base_flange, perturb) - self.known(values, T_base_flange, perturb)
        normals: Array = apart / np.linalg.norm(apart, axis=-1, keepdims=True)
        return normals

    def _sensor_in_base(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """T_base_sensor, (c, n or 1, 4, 4)."""
        return motion(values, "hand_eye")[:, None] if self.is_static else T_base_flange @ self._mount(values, perturb)

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """`point` [m], equal along x and z of the sensor, each row's own."""
        normals = self._normals(values, T_base_flange, perturb)[0]
        axes = self._sensor_in_base(values, T_base_flange, perturb)[0, :, :3, :3:2]
        effect = normals[:, None] @ (axes if self.is_static else axes[self.dataset.points.pose])
        return [ErrorSource("point", effect, np.arange(len(effect)), stated=self.dataset.noise.point_m)]

    def in_cell(self, values: Values, perturb: Perturbation) -> InCell:
        """The sensor as `profile_sensor`, at the first pose; balls on the flange as `ball_NAME`."""
        if not self.is_static:
            mount = self._mount(values, perturb)
            sensor = {"profile_sensor": mount[0, 0]}
            return InCell(sensor, published=sensor, mount=mount)
        sensor = {"profile_sensor": motion(values, "hand_eye")[0]}
        middles = zip(self.names, places(values, "ball", self.names)[0], strict=True)
        balls = {f"ball_{name}": pose(np.eye(3), middle) for name, middle in middles}
        return InCell(balls, sensor, published=sensor)

    def _aims(self, values: Values, T_base_flange: Array) -> tuple[Array, Array]:
        """Balls go where balls were seen: the ball of each profile in the flange frame and in the base frame."""
        of_pose = self.dataset.points.pose
        _, first = np.unique(of_pose * len(self.names) + self.ball, return_index=True)
        there = self.known(values, T_base_flange[None], Perturbation())[0, first]
        return apply(inverse(T_base_flange[of_pose[first]]), there), there

    @property
    def new_poses(self) -> NewPoses:
        """Profiles of the balls."""
        return NewPoses(self._seen_from, self._aims)

    def _seen_from(self, values: Values, T_base_flange: Array) -> tuple[Points, Bools]:
        """A profile of the ball nearest to the sensor's plane; good if cut near its middle, in range."""
        balls = places(values, "ball", self.names)[0]
        radii = self._radii(values)[0]
        hand_eye = motion(values, "hand_eye")
        there = apply(T_base_flange[:, None], balls) if self.is_static else balls
        T_base_sensor = hand_eye if self.is_static else T_base_flange @ hand_eye
        there = apply(inverse(T_base_sensor)[:, None], there)
        measured = self.dataset.points["profile"]
        low, high = measured.min(axis=0), measured.max(axis=0)
        near = there - radii[:, None] * (0.0, 0.0, 1.0)
        inside = ((near[..., ::2] >= low) & (near[..., ::2] <= high)).all(axis=-1)
        beside = np.where(inside, np.abs(there[..., 1]) / radii, np.inf)
        nearest, poses = beside.argmin(axis=1), np.arange(len(T_base_flange))
        x, y, z = there[poses, nearest].T[..., None]
        radius, angle = np.sqrt(np.maximum(radii[nearest, None] ** 2 - y**2, 0.0)), np.linspace(-ARC, ARC, ROWS)
        profile = np.stack([x + radius * np.sin(angle), z - radius * np.cos(angle)], axis=-1)
        names = tuple(self.names[ball] for ball in nearest.repeat(ROWS).tolist())
        points = Points(poses.repeat(ROWS), names, columns={"profile": profile.reshape(-1, 2)})
        return points, np.asarray(beside[poses, nearest] < MOST_CUT)


def _radius(ball: str) -> str:
    """The name of an unstated ball radius."""
    return f"ball.{ball}.radius"


def _of_largest(cuts: Array) -> Array:
    """The radius of a ball from radii of circles in which planes cut it, some of them badly seen, (n,) -> (1,)."""
    return np.asarray(np.quantile(np.append(cuts, 0.0), [0.9]))


def circles(points: Array, group: Ints) -> tuple[Array, Array, Bools]:
    """Circles through groups of points (m, 2) [m], by linear least squares (Kåsa 1976).

    Returns:
        Centres (g, 2) and radii (g,) [m], and which groups, numbered from 0, have enough points.
    """
    counts = np.bincount(group)
    mean = group_sums(points, group) / counts[:, None]
    local = points - mean[group]
    A = np.column_stack([2.0 * local, np.ones(len(local))])
    normal = group_sums(A[:, :, None] * A[:, None], group)
    right = group_sums(A * (local**2).sum(axis=1, keepdims=True), group)
    solved = (np.linalg.pinv(normal, hermitian=True) @ right[..., None])[..., 0]
    radius = np.sqrt(np.maximum(solved[:, 2] + (solved[:, :2] ** 2).sum(axis=1), 0.0))
    return mean + solved[:, :2], radius, counts >= LEAST_ROWS


def sensor_and_balls(centre: Array, beside: Array, T: Array, ball: Ints) -> tuple[Array, Array, Array]:
    """R and s that bring R (T ball) + s to where the profiles locate the balls, and the balls.

    A profile does not determine on which side of its plane the ball's centre is. Sides and positions are found in
    turns, from several guesses of the sides; the smallest residual is taken.

    Args:
        centre: Of the circle in each profile, along x and z of the sensor, (g, 2) [m].
        beside: Distance of the ball's centre from the profile's plane, (g,) [m].
        T: Motions that bring balls from where they are fixed to the frame that the sensor is fixed in, (g, 4, 4).
        ball: Of each profile, (g,).

    Returns:
        R (3, 3), s (3,) [m] and the balls where they are fixed, (b, 3) [m].
    """
    g, rng = len(beside), np.random.default_rng(0)
    side = np.concatenate([np.zeros((1, g)), rng.choice([-1.0, 1.0], (GUESSES, g))])
    measured = np.tile(np.insert(centre, 1, 0.0, axis=1), (len(side), 1, 1))
    for _ in range(ROUNDS):
        measured[..., 1] = side * beside
        R, s, balls = base_and_tools(measured, T[None], ball)
        there = (T[:, :3, :3] @ balls[:, ball][..., None])[..., 0] + T[:, :3, 3]
        predicted = there @ np.swapaxes(R, -1, -2) + s[:, None]
        before, side = side, np.where(predicted[..., 1] < 0.0, -1.0, 1.0)
        if (side == before).all():
            break
    measured[..., 1] = side * beside
    best = np.argmin(np.square(measured - predicted).sum(axis=(1, 2)))
    return R[best], s[best], balls[best]
