"""Small motions at the stages: how a row would move if its pose, pixel, laser plane or target were off by a little."""

from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.diagnosis.fit import Fit
from robolaser.duals import Dual
from robolaser.geometry.rigid_motion import pose
from robolaser.model.stages import OF_ROWS, Perturbation, Stage
from robolaser.robot.flange_motion import FlangeMotion, moved_by_twists

REMEMBERED = 3
"""Fits whose derivatives are kept."""
NUMBERS = {Stage.PIXELS: 2, Stage.IMAGE: 2, Stage.LASER_PLANE: 4, Stage.POINTS: 3, Stage.TARGET: 3}
"""How many numbers of a row pass these stages."""
TWISTS = moved_by_twists(np.eye(4)[None, None], np.eye(6)[None, :, None])[0, :, 0]
"""What is added to a motion that is none by shifts along the axes and turns about them, (6, 4, 4)."""


@final
class StageDerivatives:
    """Whitened residuals of a fitted model by what passes a stage, each row by its own.

    Args:
        fit: The model.
    """

    def __init__(self, fit: Fit) -> None:
        self._fit, self._model = fit, fit.model
        self._known: dict[tuple[Stage, str], Array] = {}
        self._by_row: dict[Stage, Array] = {}

    def passing(self, stage: Stage) -> Array | None:
        """What passes a stage; None where the sensor does not have it, or sessions differ in what all rows share."""
        seen: list[Array] = []

        def note(value: Array) -> Array:
            seen.append(value)
            return value

        self._residuals(stage, note)
        if stage not in OF_ROWS or len(seen) < 2 or seen[0].shape[1] == 1:
            return seen[-1][0] if seen and all(np.array_equal(value, seen[0]) for value in seen) else None
        passed: Array = np.zeros_like(seen[0][0])
        passing = (block for block in self._model.blocks if stage in block.sensor.stages)
        for block, value in zip(passing, seen, strict=True):
            passed[block.rows] = value[0, block.rows] if value.shape[1] > 1 else value[0]
        return passed

    def _by(self, stage: Stage, act: Callable[[Any], Any], *, first: bool = False, of: Bools | None = None) -> Array:
        """Derivatives by what moves the value in an act after a stage's effects, or before them, (K, q).

        Of the rows (m,) that see it move, or all.
        """
        slopes = self._residuals(stage, act, first=first).slopes[:, 0]
        return self._fit.noise.whiten(slopes if of is None else slopes * of[:, None]).T

    def _residuals(self, stage: Stage, act: Callable[[Any], Any], *, first: bool = False) -> Any:
        """Residuals at the optimum, with something done after a stage's effects or before them."""
        model, values = self._model, self._fit.problem.parameters.values(self._fit.x[None])
        steps, own = model.perturb(values).steps, (stage, act)
        perturb = Perturbation((own, *steps) if first else (*steps, own))
        return model.blocks.residuals(values, model.flange(values, perturb, only_seen=True), perturb)

    def by_row(self, stage: Stage) -> Array:
        """Of the residuals themselves, by shifts of what each row passes, (q, m, k) [row's unit/px or 1/m]."""
        if stage not in self._by_row:
            shift = Dual(np.zeros(NUMBERS[stage]), np.eye(NUMBERS[stage]), tuple(range(NUMBERS[stage])))
            self._by_row[stage] = self._residuals(stage, lambda value: value + shift).slopes[:, 0]
        return self._by_row[stage]

    def of_rows(self, stage: Stage, moves: Array) -> Array:
        """Of the whitened residuals, by what moves each row's own value at a stage, (g, m or 1, q): (K, g).

        Noise that rows share mixes them: what differs from row to row is whitened after it was multiplied.
        """
        return self._fit.noise.whiten(np.einsum("qmk,gmq->gmk", self.by_row(stage), moves)).T

    def by_motion(self, stage: Stage, joint: str = "") -> Array:
        """By small motions of what passes a stage, (K, q): shifts and turns in its own frame [1/m, 1/rad].

        Args:
            stage: `JOINTS`: a joint's value, (K, 1) [1/rad or 1/m]. `LINKS`: shifts and turns of a joint on the link
                before it. `FLANGE`, `MOUNT`: of what it carries.
            joint: Where it is one of the arm's, the joint.
        """
        if (stage, joint) not in self._known:
            self._known[stage, joint] = self._by_motion(stage, joint)
        return self._known[stage, joint]

    def _by_motion(self, stage: Stage, joint: str) -> Array:
        if stage in (Stage.JOINTS, Stage.LINKS):
            return self._of_arm(stage, joint)
        return self._by(stage, lambda value: value @ _motion(TWISTS))

    def _of_arm(self, stage: Stage, joint: str) -> Array:
        """By motions of one joint, (K, 1), or link, (K, 6): they move the flange in six ways, and rows by these."""
        robot, _ = self._model.dataset.arm
        placements, motion = self._arm
        i = robot.joints.index(joint)
        if stage is Stage.JOINTS:
            twists = motion.twists_by_joints(np.eye(len(robot.joints))[None, [i], None])
        else:
            moves = np.zeros((1, len(TWISTS), *placements.shape[1:]))
            moves[:, :, :, i] = TWISTS[:, None]
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
        return self._by(Stage.FLANGE, lambda value: _motion(TWISTS) @ value, first=True)

    def base(self, centre: Array, of: Bools | None = None) -> Array:
        """By shifts and turns of the flange, in the base frame and about a centre (3,), (K, 6) [1/m, 1/rad].

        Of the rows (m,) that see it move, or all.
        """
        there, back = pose(np.eye(3), centre), pose(np.eye(3), -centre)
        return self._by(Stage.FLANGE, lambda value: _motion(there @ TWISTS @ back) @ value, of=of)


@lru_cache(maxsize=REMEMBERED)
def stage_derivatives(fit: Fit) -> StageDerivatives:
    """Those of a fit, each worked out once; of the last fits only."""
    return StageDerivatives(fit)


def _motion(slopes: Array) -> Dual:
    """No motion, with what is added to it in each of q ways (q, 4, 4)."""
    return Dual(np.eye(4), slopes, tuple(range(len(slopes))))
