"""Derivatives of the residuals by effects, by the chain rule through the value at their stage."""

from functools import lru_cache
from typing import Any, cast, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.stage_derivatives import StageDerivatives, stage_derivatives
from robolaser.duals import Dual, slopes_of
from robolaser.geometry.rigid_motion import own_twists
from robolaser.model.effects.effect import CandidateEffect, perturb_with
from robolaser.model.effects.run import Run
from robolaser.model.forward_model import Model
from robolaser.model.stages import OF_ROWS, Stage
from robolaser.parameters import Values


def prior_scales(candidate_effect: CandidateEffect) -> Array:
    """Prior scales of an effect's linear parameters, in their units, (a,)."""
    return np.array([scale for *_, scale in candidate_effect.effect.amplitudes()])


@final
class Columns:
    """Derivatives of whitened residuals by effects' parameters and by joint angles, cached for similar models.

    A model with one effect more or less has nearly the same derivatives, and differs in those that its parameters
    imitate. Refits decide in the end.
    """

    def __init__(self) -> None:
        self._by_effect: dict[tuple[CandidateEffect, bytes], Array] = {}
        self._by_motion: dict[tuple[Stage, str], Array] = {}
        self._of_rows: dict[Stage, StageDerivatives] = {}
        self._passing: dict[Stage, Array | None] = {}

    def by_effect(self, fit: Fit, candidate_effect: CandidateEffect, grid: Array) -> Array:
        """By the linear parameters in units of their prior scales, for nonlinear parameters (g, s): (K, g a)."""
        key = candidate_effect, grid.tobytes()
        if key not in self._by_effect:
            self._by_effect[key] = self._computed(fit, candidate_effect, grid)
        return self._by_effect[key]

    def _computed(self, fit: Fit, candidate_effect: CandidateEffect, grid: Array) -> Array:
        stage = candidate_effect.effect.stage_in(fit.model.dataset)
        if stage is Stage.JOINTS:
            return self._by_joints(fit, stage_moves(fit.model, candidate_effect, grid, fit.model.dataset.arm[1]))
        value = self._passed(fit, stage)
        if value is None:  # the value differs between sessions
            columns = fit.at.columns(candidate_effect, grid) * prior_scales(candidate_effect)
            return np.moveaxis(columns, 0, 1).reshape(columns.shape[1], -1)
        return self._through(fit, stage, value, stage_moves(fit.model, candidate_effect, grid, value))

    def by_parameters(self, fit: Fit, candidate_effect: CandidateEffect, x: Array) -> Array | None:
        """By all parameters of an effect at values x (p,), per unit of each, (K, p); None if unknown."""
        stage = candidate_effect.effect.stage_in(fit.model.dataset)
        value = fit.model.dataset.arm[1] if stage is Stage.JOINTS else self._passed(fit, stage)
        if value is None:
            return None

        moves = _slopes(fit.model, candidate_effect, x[None], np.eye(len(x)), value)
        return self._by_joints(fit, moves) if stage is Stage.JOINTS else self._through(fit, stage, value, moves)

    def _passed(self, fit: Fit, stage: Stage) -> Array | None:
        if stage not in self._passing:
            self._passing[stage] = stage_derivatives(fit).passing(stage)
        return self._passing[stage]

    def _through(self, fit: Fit, stage: Stage, value: Array, moves: Array) -> Array:
        """By increments of a stage's value, (q, ...): (K, q)."""
        if stage in OF_ROWS:
            return self._of_rows.setdefault(stage, stage_derivatives(fit)).of_rows(stage, moves)
        twists = own_twists(value, moves)
        if stage is not Stage.LINKS:
            return _chained(twists, self._by_stage(fit, stage), fit.pose_of_number)
        columns = np.zeros((len(fit.pose_of_number), len(twists)))
        for i in np.flatnonzero(twists.any(axis=(0, 1, 3))):
            by_one = self._by_stage(fit, stage, fit.model.dataset.arm[0].joints[i])
            columns += _chained(twists[:, :, i], by_one, fit.pose_of_number)
        return columns

    def _by_joints(self, fit: Fit, moves: Array) -> Array:
        """By motions of joints, (g a, n, j), which move the rows of their own pose: (K, g a)."""
        robot, _ = fit.model.dataset.arm
        columns = np.zeros((len(fit.pose_of_number), len(moves)))
        for i in np.flatnonzero(moves.any(axis=(0, 1))):
            columns += _chained(moves[:, :, [i]], self.by_joint(fit, robot.joints[i])[:, None], fit.pose_of_number)
        return columns

    def by_joint(self, fit: Fit, joint: str) -> Array:
        """By the joint's value in each row's own pose, (K,)."""
        return self._by_stage(fit, Stage.JOINTS, joint)[:, 0]

    def _by_stage(self, fit: Fit, stage: Stage, joint: str = "") -> Array:
        """By small motions of a stage's value, (K, q)."""
        if (stage, joint) not in self._by_motion:
            self._by_motion[stage, joint] = stage_derivatives(fit).by_motion(stage, joint)
        return self._by_motion[stage, joint]


def stage_moves(model: Model, candidate_effect: CandidateEffect, grid: Array, value: Array) -> Array:
    """Derivatives of a stage's output by an effect's amplitudes in units of prior scales, (g a, ...).

    They are cached: another noise, or effects at other stages, leave a stage's input unchanged.

    Args:
        model: The model whose run the effect depends on.
        candidate_effect: An effect at the stage.
        grid: Values of its nonlinear parameters, (g, s).
        value: The stage's input.
    """
    known, key = _moves_in(model.run), (candidate_effect, grid.tobytes())
    if key not in known or not np.array_equal(known[key][0], value):
        scales = prior_scales(candidate_effect)
        x = np.hstack([np.zeros((len(grid), len(scales))), grid])
        directions = np.eye(x.shape[1])[: len(scales)] * scales[:, None]
        known[key] = value, _slopes(model, candidate_effect, x, directions, value)
    return known[key][1]


@lru_cache(maxsize=1)
def _moves_in(run: Run) -> dict[tuple[CandidateEffect, bytes], tuple[Array, Array]]:
    """The stages' inputs and derivatives that are known in a run; only those of the last run are cached."""
    return {}


def _slopes(model: Model, candidate_effect: CandidateEffect, x: Array, directions: Array, value: Array) -> Array:
    """Derivatives of a stage's output at an effect's parameters x (c, p), along directions (q, p), (c q, ...)."""
    numbers: list[Any] = []
    for at, way in zip(x.T, directions.T, strict=True):
        by = np.flatnonzero(way)
        slopes = np.repeat(way[by, None], len(x), axis=1)
        numbers.append(Dual(at, slopes, tuple(by.tolist())) if len(by) else at)
    effect = candidate_effect.at(cast("Values", dict(zip(candidate_effect.parameters.names, numbers, strict=True))))
    moved = perturb_with((effect,), model.run)(candidate_effect.effect.stage_in(model.dataset), value[None])
    return np.swapaxes(slopes_of(moved, len(directions)), 0, 1).reshape(-1, *moved.shape[1:])


def _chained(moves: Array, slopes: Array, of_number: Ints) -> Array:
    """Derivatives (K, q) by motions of each number's pose or row, times these motions (g, n, q): (K, g)."""
    if moves.shape[1] == 1:
        return slopes @ moves[:, 0].T
    return np.asarray(np.einsum("gkq,kq->kg", moves[:, of_number], slopes))
