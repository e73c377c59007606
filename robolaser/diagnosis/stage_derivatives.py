"""Derivatives at the stages: motion of a row by small changes of its pose, pixel, laser plane or target."""

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

REMEMBERED = 3  # number of fits whose derivatives are cached
TWISTS = moved_by_twists(np.eye(4)[None, None], np.eye(6)[None, :, None])[0, :, 0]
"""Derivatives of a rigid motion at the identity by shifts along the axes and turns about them, (6, 4, 4)."""


@final
class StageDerivatives:
    """Derivatives of a fitted model's whitened residuals, each row by its own value at a stage."""

    def __init__(self, fit: Fit) -> None:
        self._fit, self._model = fit, fit.model
        self._known: dict[tuple[Stage, str], Array] = {}
        self._by_row: dict[Stage, Array] = {}

    def passing(self, stage: Stage) -> Array | None:
        """The value at a stage; None if the sensor lacks the stage, or a value of all rows differs between sessions."""
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
        """Derivatives by an action on the value after a stage's effects, or before them, (K, q).

        Only the rows in the mask (m,), if given, are affected.
        """
        slopes = self._residuals(stage, act, first=first).slopes[:, 0]
        return self._fit.noise.whiten(slopes if of is None else slopes * of[:, None]).T

    def _residuals(self, stage: Stage, act: Callable[[Any], Any], *, first: bool = False) -> Any:
        """Residuals at the optimum, with an action after a stage's effects or before them."""
        model, values = self._model, self._fit.problem.parameters.values(self._fit.x[None])
        steps, own = model.perturb(values).steps, (stage, act)
        perturb = Perturbation((own, *steps) if first else (*steps, own))
        return model.blocks.residuals(values, model.flange(values, perturb, only_seen=True), perturb)

    def by_row(self, stage: Stage) -> Array:
        """Derivatives of the residuals by shifts of each row's value, (q, m, k) [row's unit/px or 1/m]."""
        if stage not in self._by_row:
            self._by_row[stage] = self._residuals(stage, _shifted).slopes[:, 0]
        return self._by_row[stage]

    def of_rows(self, stage: Stage, moves: Array) -> Array:
        """Derivatives of the whitened residuals by moves of each row's value at a stage, (g, m or 1, q): (K, g).

        Shared noise mixes rows: the products are whitened, not the derivatives before multiplication.
        """
        return self._fit.noise.whiten(np.einsum("qmk,gmq->gmk", self.by_row(stage), moves)).T

    def by_motion(self, stage: Stage, joint: str = "") -> Array:
        """Derivatives by small motions at a stage, (K, q): shifts and turns in its own frame [1/m, 1/rad].

        Args:
            stage: `JOINTS`: a joint's value, (K, 1) [1/rad or 1/m]. `LINKS`: shifts and turns of a joint on the link
                before it. `FLANGE`, `MOUNT`: shifts and turns of the body there.
            joint: The joint, for stages of the arm.
        """
        if (stage, joint) not in self._known:
            of_arm = stage in (Stage.JOINTS, Stage.LINKS)
            moved = self._of_arm(stage, joint) if of_arm else self.of_body(stage)
            self._known[stage, joint] = moved
        return self._known[stage, joint]

    def of_body(self, stage: Stage, of: Bools | None = None) -> Array:
        """By shifts and turns of the body at the stage `FLANGE` or `MOUNT`, of the rows in the mask (m,), (K, 6)."""
        return self._by(stage, lambda value: value @ _motion(TWISTS), of=of)

    def _of_arm(self, stage: Stage, joint: str) -> Array:
        """By motions of one joint, (K, 1), or link, (K, 6), through the six motions of the flange."""
        robot, _ = self._model.dataset.arm
        placements, motion = self._arm
        i = robot.joints.index(joint)
        if stage is Stage.JOINTS:
            twists = motion.twists_by_joints(np.eye(len(robot.joints))[None, [i], None])
        else:
            moves = np.zeros((1, len(TWISTS), *placements.shape[1:]))
            moves[:, :, :, i] = TWISTS[:, None]
            twists = motion.twists_by_placements(placements, placements[:, None] @ moves)
        return np.asarray(np.einsum("qkd,kd->kq", twists[0][:, self._fit.pose_of_number], self._by_flange))

    @cached_property
    def _arm(self) -> tuple[Array, FlangeMotion]:
        """The placements of the joints, (1, n or 1, j, 4, 4), and the resulting flange motion at each pose."""
        robot, q = self._model.dataset.arm
        perturb = self._model.perturb(self._fit.problem.parameters.values(self._fit.x[None]))
        placements = perturb(Stage.LINKS, robot.placements[None, None])
        return placements, robot.motion(perturb(Stage.JOINTS, q[None]), placements)

    @cached_property
    def _by_flange(self) -> Array:
        """By twists of the flange in the base frame, before the effects there, (K, 6)."""
        return self._by(Stage.FLANGE, lambda value: _motion(TWISTS) @ value, first=True)

    def base(self, centre: Array, of: Bools | None = None) -> Array:
        """By shifts and turns of the flange, in the base frame and about a centre (3,), (K, 6) [1/m, 1/rad].

        Only the rows in the mask (m,), if given, are affected.
        """
        there, back = pose(np.eye(3), centre), pose(np.eye(3), -centre)
        return self._by(Stage.FLANGE, lambda value: _motion(there @ TWISTS @ back) @ value, of=of)


@lru_cache(maxsize=REMEMBERED)
def stage_derivatives(fit: Fit) -> StageDerivatives:
    """The derivatives of a fit, each computed once; those of the last fits are cached."""
    return StageDerivatives(fit)


def _shifted(value: Array) -> Any:
    """The value (c, m, k) with derivatives by each of its numbers."""
    k = value.shape[-1]
    return value + Dual(np.zeros(k), np.eye(k), tuple(range(k)))


def _motion(slopes: Array) -> Dual:
    """The identity with q derivatives (q, 4, 4)."""
    return Dual(np.eye(4), slopes, tuple(range(len(slopes))))
