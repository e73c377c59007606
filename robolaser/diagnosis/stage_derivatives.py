"""Small motions at the stages: how a row would move if its pose, pixel, laser plane or target were off by a little."""

from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.fit import Fit
from robolaser.finite_differences import central_differences
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.stages import OF_ROWS, Perturbation, Stage
from robolaser.robot.flange_motion import FlangeMotion, moved_by_twists

SHIFT_M, TURN_RAD, PIXEL_PX, IMAGE_M = 1e-5, 1e-5, 1e-2, 1e-7
"""Steps of the derivatives."""
REMEMBERED = 3
"""Fits whose derivatives are kept."""
TWIST = np.repeat([SHIFT_M, TURN_RAD], 3)
SHIFTS = {
    Stage.PIXELS: (2, PIXEL_PX),
    Stage.IMAGE: (2, IMAGE_M),
    Stage.LASER_PLANE: (4, SHIFT_M),
    Stage.POINTS: (3, SHIFT_M),
    Stage.TARGET: (3, SHIFT_M),
}
"""How many numbers of a row pass these stages, and the step of each."""


@final
class StageDerivatives:
    """Whitened residuals of a fitted model by what passes a stage, each row by its own.

    Args:
        fit: The model.
    """

    def __init__(self, fit: Fit) -> None:
        self._fit, self._model = fit, fit.model
        self._known: dict[tuple[Stage, str], Array] = {}

    def passing(self, stage: Stage) -> Array | None:
        """What passes a stage; None where the sensor does not have it, or sessions differ in what all rows share."""
        seen: list[Array] = []

        def note(value: Array) -> Array:
            seen.append(value)
            return value

        self._residuals(1, stage, note)
        if stage not in OF_ROWS or len(seen) < 2 or seen[0].shape[1] == 1:
            return seen[-1][0] if seen and all(np.array_equal(value, seen[0]) for value in seen) else None
        passed: Array = np.zeros_like(seen[0][0])
        passing = (block for block in self._model.blocks if stage in block.sensor.stages)
        for block, value in zip(passing, seen, strict=True):
            passed[block.rows] = value[0, block.rows]
        return passed

    def _by(
        self, stage: Stage, moves: Callable[[Array], Array], steps: Array, *, left: bool = False, first: bool = False
    ) -> Array:
        """Derivatives by moves, (K, q), which shifts (n, q) make, given their steps (q,); before a stage's effects?"""

        def residuals(shifts: Array) -> Array:
            made = moves(shifts)

            def nudge(value: Array) -> Array:
                move = made.reshape(len(made), *(1,) * (value.ndim - made.ndim), *made.shape[1:])
                if stage in (Stage.FLANGE, Stage.LINKS, Stage.MOUNT):
                    return move @ value if left else value @ move
                return value + move

            return self._residuals(len(shifts), stage, nudge, first=first)

        slopes = np.moveaxis(central_differences(residuals, steps), -1, 0)
        return self._fit.noise.whiten(slopes).T

    def _residuals(self, count: int, stage: Stage, act: Callable[[Array], Array], *, first: bool = False) -> Array:
        """Residuals of as many candidates, all at the optimum, with something done after a stage's effects or first."""
        model = self._model
        values = self._fit.problem.parameters.values(np.repeat(self._fit.x[None], count, axis=0))
        steps, own = model.perturb(values).steps, (stage, act)
        perturb = Perturbation((own, *steps) if first else (*steps, own))
        robot, q = model.dataset.robot, model.dataset.poses.q
        if robot is None or q is None:
            flange = perturb(Stage.FLANGE, model.dataset.flange()[None])
        else:
            joints = perturb(Stage.JOINTS, q[None])
            flange = perturb(Stage.FLANGE, robot.forward(joints, perturb(Stage.LINKS, robot.placements[None, None])))
        return model.blocks.residuals(values, flange, perturb)

    def _by_shift(self, stage: Stage, directions: Array, step: float) -> Array:
        """By shifts of the stage's value, one along each of some directions (q, j)."""
        return self._by(stage, lambda shifts: shifts @ directions, np.full(len(directions), step))

    def by_motion(self, stage: Stage, joint: str = "") -> Array:
        """By small motions of what passes a stage, (K, q): shifts and turns in its own frame [1/m, 1/rad], or shifts.

        Args:
            stage: Which.
            joint: Where it is one of the arm's, the joint.
        """
        if (stage, joint) not in self._known:
            self._known[stage, joint] = self._by_motion(stage, joint)
        return self._known[stage, joint]

    def _by_motion(self, stage: Stage, joint: str) -> Array:
        if stage in (Stage.JOINTS, Stage.LINKS):
            return self._of_arm(stage, joint)
        if stage in (Stage.FLANGE, Stage.MOUNT):
            return self._by(stage, _motions, TWIST)
        numbers, step = SHIFTS[stage]
        return self._by_shift(stage, np.eye(numbers), step)

    def joint(self, name: str) -> Array:
        """By a joint's value, (K, 1) [1/rad or 1/m]."""
        return self.by_motion(Stage.JOINTS, name)

    def placement(self, joint: str) -> Array:
        """By shifts and turns of a joint on the link before it, in its own frame, (K, 6) [1/m, 1/rad]."""
        return self.by_motion(Stage.LINKS, joint)

    def _of_arm(self, stage: Stage, joint: str) -> Array:
        """By motions of one joint, (K, 1), or link, (K, 6): they move the flange in six ways, and rows by these."""
        robot, _ = self._model.dataset.arm
        placements, motion = self._arm
        i = robot.joints.index(joint)
        if stage is Stage.JOINTS:
            twists = motion.twists_by_joints(np.eye(len(robot.joints))[None, [i], None])
        else:
            moves = np.zeros((1, len(TWIST), *placements.shape[1:]))
            moves[:, :, :, i] = moved_by_twists(np.eye(4)[None, None], np.eye(len(TWIST))[None, :, None])
            twists = motion.twists_by_placements(placements, placements[:, None] @ moves)
        moved: Array = np.einsum("qkd,kd->kq", twists[0][:, self._fit.pose_of_number], self._by_flange)
        return moved

    @cached_property
    def _arm(self) -> tuple[Array, FlangeMotion]:
        """The placements of the joints, (1, n or 1, j, 4, 4), and how the flange moves with them at each pose."""
        robot, q = self._model.dataset.arm
        perturb = self._model.perturb(self._fit.problem.parameters.values(self._fit.x[None]))
        placements = perturb(Stage.LINKS, robot.placements[None, None])
        return placements, robot.motion(perturb(Stage.JOINTS, q[None]), placements)

    @cached_property
    def _by_flange(self) -> Array:
        """By twists of the flange in the base frame as the arm carries it, before the effects there, (K, 6)."""
        return self._by(Stage.FLANGE, _motions, TWIST, left=True, first=True)

    def base(self, centre: Array) -> Array:
        """By shifts and turns of the flange, in the base frame and about a centre (3,), (K, 6) [1/m, 1/rad]."""
        there, back = pose(np.eye(3), centre), pose(np.eye(3), -centre)
        return self._by(Stage.FLANGE, lambda twists: there @ _motions(twists) @ back, TWIST, left=True)

    def tool(self) -> Array:
        """By shifts and turns of what the flange carries, in its frame, (K, 6) [1/m, 1/rad]."""
        return self.by_motion(Stage.FLANGE)

    def pixel(self) -> Array:
        """By the pixel's u and v, (K, 2) [1/px]."""
        return self.by_motion(Stage.PIXELS)

    def laser_plane(self) -> Array:
        """By the distance of the laser plane from where it should be, (K, 1) [1/m]."""
        return self.by_motion(Stage.LASER_PLANE)[:, 3:]

    def turned_laser_plane(self) -> Array:
        """By its distance from where it should be, in proportion to the depth: it turns, (K, 1)."""
        return self._by_shift(Stage.LASER_PLANE, np.array([[0.0, 0.0, 1.0, 0.0]]), TURN_RAD)

    def target(self) -> Array:
        """By the point's place on the target, (K, 3) [1/m]."""
        return self.by_motion(Stage.TARGET)


@lru_cache(maxsize=REMEMBERED)
def stage_derivatives(fit: Fit) -> StageDerivatives:
    """Those of a fit, each worked out once; of the last fits only."""
    return StageDerivatives(fit)


def _motions(twists: Array) -> Array:
    """Rigid motions (n, 4, 4) of shifts and turns (n, 6) [m, rad]."""
    return pose(exp_so3(twists[:, 3:]), twists[:, :3])
