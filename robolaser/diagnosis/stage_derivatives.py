"""Small motions at the stages: how a row would move if its pose, pixel, light or target were off by a little."""

from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.penalized_fit import Fit
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.sensors.stripe import Stripe
from robolaser.model.stages import Perturbation, Stage

SHIFT_M, TURN_RAD, PIXEL_PX = 1e-5, 1e-5, 1e-2
"""Steps of the derivatives."""


@final
class StageDerivatives:
    """Whitened residuals of a fitted model by what passes a stage, each row by its own.

    Args:
        fitted: The model.
    """

    def __init__(self, fitted: Fit) -> None:
        self._problem = fitted.problem
        self._values = fitted.problem.parameters.values(fitted.x[None])
        self._bend = self._problem.model.perturb(self._values)

    def _by(self, stage: Stage, moves: list[tuple[Array, Array, float]], *, left: bool = False) -> Array:
        """Derivatives by moves, each a pair of values for both ways and the step; (3m, len(moves))."""
        columns = [
            (self._residuals(stage, up, left=left) - self._residuals(stage, down, left=left)) / (2 * h)
            for up, down, h in moves
        ]
        return self._problem.noise.whiten(np.concatenate(columns)).T

    def _residuals(self, stage: Stage, move: Array, *, left: bool) -> Array:
        def nudge(value: Array) -> Array:
            if stage in (Stage.FLANGE, Stage.LINKS):
                return move @ value if left else value @ move
            return value + move

        moved = Perturbation((*self._bend.steps, (stage, nudge)))
        model = self._problem.model
        robot, q = model.dataset.robot, model.dataset.poses.q
        if robot is None or q is None:
            flange = moved(Stage.FLANGE, model.dataset.flange()[None])
        else:
            joints = moved(Stage.JOINTS, q[None])
            flange = moved(Stage.FLANGE, robot.forward(joints, moved(Stage.LINKS, robot.placements[None, None])))
        e: Array = model.sensor.residuals(self._values, flange, moved)
        return e

    def joint(self, name: str) -> Array:
        """By a joint's value, (3m, 1) [1/rad or 1/m]."""
        robot = self._problem.model.dataset.robot
        assert robot is not None
        step = TURN_RAD * np.eye(len(robot.joints))[robot.joints.index(name)]
        return self._by(Stage.JOINTS, [(step, -step, TURN_RAD)])

    def placement(self, joint: str) -> Array:
        """By shifts and turns of a joint on the link before it, in its own frame, (3m, 6) [1/m, 1/rad]."""
        robot = self._problem.model.dataset.robot
        assert robot is not None
        column, still = robot.joints.index(joint), np.tile(np.eye(4), (len(robot.joints), 1, 1))

        def of_one(move: Array) -> Array:
            moves = still.copy()
            moves[column] = move
            return moves

        return self._by(Stage.LINKS, [(of_one(up), of_one(down), h) for up, down, h in _twists()])

    def base(self, centre: Array) -> Array:
        """By shifts and turns of the flange, in the base frame and about a centre (3,), (3m, 6) [1/m, 1/rad]."""
        to, fro = pose(np.eye(3), centre), pose(np.eye(3), -centre)
        return self._by(Stage.FLANGE, [(to @ up @ fro, to @ down @ fro, h) for up, down, h in _twists()], left=True)

    def tool(self) -> Array:
        """By shifts and turns of what the flange carries, in its frame, (3m, 6) [1/m, 1/rad]."""
        return self._by(Stage.FLANGE, _twists())

    def pixel(self) -> Array:
        """By the pixel's u and v, (3m, 2) [1/px]."""
        return self._by(Stage.PIXELS, [(step, -step, PIXEL_PX) for step in PIXEL_PX * np.eye(2)])

    def sheet(self) -> Array:
        """By the distance of the light from where it should be, (3m, 1) [1/m]."""
        step = SHIFT_M * np.array([0.0, 0.0, 0.0, 1.0])
        return self._by(Stage.LASER_PLANE, [(step, -step, SHIFT_M)])

    def on_sheet(self) -> Array:
        """Where on the light sheet each row's point lies: along the stripe and away from the camera, (m, 2) [m]."""
        sensor = self._problem.model.sensor
        assert isinstance(sensor, Stripe)  # nothing else has a sheet
        found: Array = sensor.in_camera(self._values, self._bend)[0, :, 1:]
        return found

    def target(self) -> Array:
        """By the point's place on the target, (3m, 3) [1/m]."""
        return self._by(Stage.TARGET, [(step, -step, SHIFT_M) for step in SHIFT_M * np.eye(3)])


def _twists() -> list[tuple[Array, Array, float]]:
    zero = np.zeros(3)
    shifts = [(pose(np.eye(3), SHIFT_M * axis), pose(np.eye(3), -SHIFT_M * axis), SHIFT_M) for axis in np.eye(3)]
    turns = [
        (pose(exp_so3(TURN_RAD * axis), zero), pose(exp_so3(-TURN_RAD * axis), zero), TURN_RAD) for axis in np.eye(3)
    ]
    return shifts + turns
