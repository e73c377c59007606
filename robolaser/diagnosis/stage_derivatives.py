"""Small motions at the stages: how a row would move if its pose, pixel, laser plane or target were off by a little."""

from collections.abc import Callable, Sequence
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.fit import Fit
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.stages import Perturbation, Stage

SHIFT_M, TURN_RAD, PIXEL_PX = 1e-5, 1e-5, 1e-2
"""Steps of the derivatives."""


@final
class StageDerivatives:
    """Whitened residuals of a fitted model by what passes a stage, each row by its own.

    Args:
        fit: The model.
    """

    def __init__(self, fit: Fit) -> None:
        self._fit, self._model = fit, fit.model

    def passing(self, stage: Stage) -> Array | None:
        """What passes a stage; None where the sensor does not have it."""
        seen: list[Array] = []

        def note(value: Array) -> Array:
            seen.append(value)
            return value

        self._residuals(1, stage, note)
        return seen[-1][0] if seen else None

    def _by(self, stage: Stage, ahead: Sequence[Array], behind: Sequence[Array], step: Array, *, left: bool) -> Array:
        """Derivatives by moves, given a step (q,) ahead and behind; (K, q)."""

        def nudge(value: Array) -> Array:
            moves = np.stack([*ahead, *behind]).reshape(
                2 * len(step), *(1,) * (value.ndim - ahead[0].ndim - 1), *ahead[0].shape
            )
            if stage in (Stage.FLANGE, Stage.LINKS):
                return moves @ value if left else value @ moves
            return value + moves

        e = self._residuals(2 * len(step), stage, nudge)
        slopes = (e[: len(step)] - e[len(step) :]) / (2 * step)[:, None, None]
        return self._fit.noise.whiten(slopes).T

    def _residuals(self, count: int, stage: Stage, act: Callable[[Array], Array]) -> Array:
        """Residuals of as many candidates, all at the optimum, with something done after the effects of a stage."""
        model = self._model
        values = self._fit.problem.parameters.values(np.repeat(self._fit.x[None], count, axis=0))
        perturb = Perturbation((*model.perturb(values).steps, (stage, act)))
        robot, q = model.dataset.robot, model.dataset.poses.q
        if robot is None or q is None:
            flange = perturb(Stage.FLANGE, model.dataset.flange()[None])
        else:
            joints = perturb(Stage.JOINTS, q[None])
            flange = perturb(Stage.FLANGE, robot.forward(joints, perturb(Stage.LINKS, robot.placements[None, None])))
        return model.sensor.residuals(values, flange, perturb)

    def _by_shift(self, stage: Stage, steps: Array) -> Array:
        """By shifts of what passes, one a row of steps (q, j)."""
        return self._by(stage, list(steps), list(-steps), np.abs(steps).max(axis=-1), left=False)

    def joint(self, name: str) -> Array:
        """By a joint's value, (K, 1) [1/rad or 1/m]."""
        robot, _ = self._model.dataset.arm
        return self._by_shift(Stage.JOINTS, TURN_RAD * np.eye(len(robot.joints))[[robot.joints.index(name)]])

    def placement(self, joint: str) -> Array:
        """By shifts and turns of a joint on the link before it, in its own frame, (K, 6) [1/m, 1/rad]."""
        robot, _ = self._model.dataset.arm
        column, still = robot.joints.index(joint), np.tile(np.eye(4), (len(robot.joints), 1, 1))

        def of_one(move: Array) -> Array:
            moves = still.copy()
            moves[column] = move
            return moves

        ahead, behind, step = _twists()
        return self._by(Stage.LINKS, list(map(of_one, ahead)), list(map(of_one, behind)), step, left=False)

    def base(self, centre: Array) -> Array:
        """By shifts and turns of the flange, in the base frame and about a centre (3,), (K, 6) [1/m, 1/rad]."""
        there, back = pose(np.eye(3), centre), pose(np.eye(3), -centre)
        ahead, behind, step = _twists()
        return self._by(
            Stage.FLANGE,
            [there @ move @ back for move in ahead],
            [there @ move @ back for move in behind],
            step,
            left=True,
        )

    def tool(self) -> Array:
        """By shifts and turns of what the flange carries, in its frame, (K, 6) [1/m, 1/rad]."""
        return self._by(Stage.FLANGE, *_twists(), left=False)

    def pixel(self) -> Array:
        """By the pixel's u and v, (K, 2) [1/px]."""
        return self._by_shift(Stage.PIXELS, PIXEL_PX * np.eye(2))

    def laser_plane(self) -> Array:
        """By the distance of the laser plane from where it should be, (K, 1) [1/m]."""
        return self._by_shift(Stage.LASER_PLANE, SHIFT_M * np.array([[0.0, 0.0, 0.0, 1.0]]))

    def target(self) -> Array:
        """By the point's place on the target, (K, 3) [1/m]."""
        return self._by_shift(Stage.TARGET, SHIFT_M * np.eye(3))


def _twists() -> tuple[list[Array], list[Array], Array]:
    """Three shifts and three turns ahead, the same behind, and their steps."""
    ways = []
    for way in (1.0, -1.0):
        shifts = [pose(np.eye(3), way * SHIFT_M * axis) for axis in np.eye(3)]
        ways.append(shifts + [pose(exp_so3(way * TURN_RAD * axis), np.zeros(3)) for axis in np.eye(3)])
    return ways[0], ways[1], np.repeat([SHIFT_M, TURN_RAD], 3)
