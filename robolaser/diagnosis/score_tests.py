"""How each suspected effect would show: whitened residuals by its numbers, less what fitted parameters imitate."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.penalized_fit import Fitted
from robolaser.diagnosis.stage_derivatives import Probe
from robolaser.model.effects.effect import CandidateEffect, Effect, perturb_with
from robolaser.model.stages import Stage

STEP = 1e-3
"""Of a derivative by an effect's number, in units of its typical size."""
DENSE = 40
"""Values of the shapes beyond which an effect on a joint is tried by way of the joint's free motion: then thousands
cost what tens do."""
SMALL = 1e-5
"""Singular values of unit columns below this share of the largest belong to directions that are not seen."""
SEEN = 1e-8
"""Share of a signature's square beyond which something of it is left that the parameters do not imitate."""


@final
@dataclass(frozen=True)
class Signature:
    """A candidate_effect, its shapes fixed, against a fitted model.

    Attributes:
        candidate_effect: Which.
        shapes: Its inner numbers, by name.
        white: Whitened residuals by its numbers in units of their typical sizes, (3m, k).
        columns: The same, the fitted parameters projected out, (3m + d, k).
        against: The fitted model.
        tried: Values of the shapes that were tried for this.
    """

    candidate_effect: CandidateEffect
    shapes: tuple[float, ...]
    white: Array
    columns: Array
    against: Fitted
    tried: int

    @cached_property
    def basis(self) -> Array:
        """Orthonormal basis of the columns, as far as anything of them is left, (3m + d, k')."""
        U, s, _ = np.linalg.svd(self.columns, full_matrices=False)
        size = float((self.white**2).sum(axis=0).max(initial=0.0))
        kept: Array = U[:, s**2 > SEEN * max(size, 1e-12)]
        return kept

    @cached_property
    def _solved(self) -> tuple[Array, float]:
        """The numbers that lower the misfit most, (k,), and by how much.

        Parameters that stand on a bound come back from it where the effect makes them.
        """
        rest, k = self.against.rest, self.columns.shape[1]
        both = np.hstack([self.columns, self.against.inward])
        steps = best_steps(both, rest)
        if (steps[k:] < 0).any():
            both, steps = self.columns, best_steps(self.columns, rest)
        ahead = rest + both @ steps
        return steps[:k], float(rest @ rest - ahead @ ahead)

    @property
    def gain(self) -> float:
        """By how much the effect would lower the squared misfit, as far as the model is linear."""
        return self._solved[1]

    @property
    def amplitudes(self) -> Array:
        """The numbers that would do so, in units of their typical sizes, (k,)."""
        return self._solved[0]

    @property
    def numbers(self) -> int:
        """How many numbers it has that the data see."""
        return int(self.basis.shape[1])


def best_steps(columns: Array, rest: Array) -> Array:
    """Steps along columns (k, n) that lower the squares of what is left (k,) most, (n,)."""
    length = np.linalg.norm(columns, axis=0)
    length = np.where(length > 0, length, 1.0)
    steps: Array = -np.linalg.lstsq(columns / length, rest, rcond=SMALL)[0] / length
    return steps


def typical(candidate_effect: CandidateEffect) -> Array:
    """Typical sizes of a candidate_effect's numbers, (k,)."""
    return np.array([size for *_, size in candidate_effect.effect.amplitudes()])


@final
class Slopes:
    """Whitened residuals by effects' numbers and by joints, worked out once and used for models near by too.

    A model with one effect more or less has nearly the same slopes; what differs is which of them its parameters can
    imitate. Fits decide in the end.
    """

    def __init__(self) -> None:
        self._of_suspect: dict[tuple[CandidateEffect, bytes], Array] = {}
        self._of_joint: dict[str, Array] = {}

    def candidate_effect(self, fitted: Fitted, candidate_effect: CandidateEffect, grid: Array) -> Array:
        """By the candidate_effect's numbers in units of their typical sizes, its shapes from a grid (g, s): (3m, g k)."""
        key = candidate_effect, grid.tobytes()
        if key not in self._of_suspect:
            columns = slopes(fitted, candidate_effect, grid)
            self._of_suspect[key] = fitted.problem.noise.whiten(columns.reshape(len(columns), -1)).T
        return self._of_suspect[key]

    def joint(self, fitted: Fitted, joint: str) -> Array:
        """By the joint's value in each row's own pose, (3m,)."""
        if joint not in self._of_joint:
            self._of_joint[joint] = Probe(fitted).joint(joint)[:, 0]
        return self._of_joint[joint]


def signatures(
    fitted: Fitted, candidate_effects: Iterable[CandidateEffect], known: Slopes | None = None
) -> list[Signature]:
    """The signature of each candidate_effect with those shapes that explain the residuals best.

    Args:
        fitted: The model that they are held against; candidate_effects that it holds already are passed over.
        candidate_effects: To be tried.
        known: Slopes of models near by.
    """
    known = known or Slopes()
    motions = JointMotions(fitted, known)
    found = []
    for candidate_effect in candidate_effects:
        if candidate_effect in fitted.effects:
            continue
        grid = candidate_effect.effect.grid(fitted.problem.model.dataset, candidate_effect.where)
        tried = len(grid)
        if tried > DENSE and candidate_effect.effect.stage is Stage.JOINTS:
            grid = motions.best(candidate_effect, grid)
        elif tried > DENSE and grid.shape[1] == 1:
            grid = _closing_in(fitted, candidate_effect, grid, known)
        found.append(_best(fitted, candidate_effect, grid, tried, known))
    return found


def afresh(signature: Signature, fitted: Fitted) -> Signature:
    """The same effect with the same shapes, against another model."""
    return _best(fitted, signature.candidate_effect, np.array([signature.shapes]), signature.tried, Slopes())


def _closing_in(fitted: Fitted, candidate_effect: CandidateEffect, grid: Array, known: Slopes) -> Array:
    """Values of the one shape from a sorted grid (g, 1) of which the best is good: ever fewer, ever denser, (g', 1)."""
    while len(grid) > DENSE:
        step = -(-len(grid) // (DENSE // 2))
        coarse = grid[::step]
        best = _best(fitted, candidate_effect, coarse, len(grid), known).shapes[0]
        at = int(np.flatnonzero(coarse[:, 0] == best)[0]) * step
        grid = grid[max(0, at - step) : at + step + 1]
    return grid


def _best(fitted: Fitted, candidate_effect: CandidateEffect, grid: Array, tried: int, known: Slopes) -> Signature:
    white = known.candidate_effect(fitted, candidate_effect, grid)
    projected = fitted.projected(white)
    k = len(candidate_effect.effect.amplitudes())
    options = [
        Signature(
            candidate_effect,
            tuple(shapes),
            white[:, i * k : (i + 1) * k],
            projected[:, i * k : (i + 1) * k],
            fitted,
            tried,
        )
        for i, shapes in enumerate(grid.tolist())
    ]
    return max(options, key=lambda option: option.gain)


def slopes(fitted: Fitted, candidate_effect: CandidateEffect, grid: Array) -> Array:
    """Plain residuals by the candidate_effect's numbers in units of their typical sizes, for each value of its shapes.

    Args:
        fitted: Where.
        candidate_effect: Which.
        grid: Values of its shapes, (g, s).

    Returns:
        (g k, m, 3) [m].
    """
    problem = fitted.problem
    model = problem.model.with_effects((*problem.model.effects, candidate_effect))
    size = typical(candidate_effect)
    k = len(size)
    steps = STEP * np.tile(np.diag(size), (len(grid), 1))
    shapes = np.repeat(grid, k, axis=0)
    base = np.repeat(fitted.x[None], len(steps), axis=0)
    names = problem.parameters.names + candidate_effect.parameters.names
    e = [model.residuals_at(dict(zip(names, np.hstack([base, way * steps, shapes]).T, strict=True))) for way in (1, -1)]
    found: Array = (e[0] - e[1]) / (2 * STEP)
    return found


@final
class JointMotions:
    """How free small motions of each joint, one for each pose, would show: any perturb of a joint is made of them."""

    def __init__(self, fitted: Fitted, known: Slopes) -> None:
        self._fitted, self._known = fitted, known
        self._of_joint: dict[str, tuple[Array, Array, Array]] = {}

    def free(self, joint: str) -> tuple[Array, Array, Array]:
        """Slope of the misfit by the joint's value in each pose, the parameters projected out, and its curvature.

        Returns:
            The slope (n,); and own (n,) and shared (n, d), the curvature being diag(own) less shared sharedᵀ.
        """
        if joint not in self._of_joint:
            columns = self._known.joint(self._fitted, joint)
            fitted = self._fitted
            of_pose = np.repeat(fitted.problem.model.dataset.points.pose, 3)
            n = len(fitted.problem.model.dataset.poses)
            Q = fitted.Q[: len(columns)]
            shared = np.zeros((n, Q.shape[1]))
            np.add.at(shared, of_pose, columns[:, None] * Q)
            slope = np.bincount(of_pose, columns * fitted.r, minlength=n) - shared @ (fitted.Q.T @ fitted.rest)
            own: Array = np.asarray(np.bincount(of_pose, columns**2, minlength=n), dtype=np.float64)
            self._of_joint[joint] = slope, own, shared
        return self._of_joint[joint]

    def best(self, candidate_effect: CandidateEffect, grid: Array) -> Array:
        """The most promising value of the shapes, (1, s)."""
        slope, own, shared = self.free(candidate_effect.where)
        scene = self._fitted.problem.model.run
        assert scene.poses.q is not None
        assert scene.robot is not None
        q = scene.poses.q[None]
        size, column = typical(candidate_effect), scene.robot.joints.index(candidate_effect.where)
        k = len(size)
        gains = []
        for part in np.array_split(grid, max(1, len(grid) * k * q.size // 2_000_000)):
            numbers = np.hstack([np.tile(np.diag(size), (len(part), 1)), np.repeat(part, k, axis=0)])
            effect = candidate_effect.at(dict(zip(candidate_effect.parameters.names, numbers.T, strict=True)))
            bent = perturb_with((effect,), scene)(Stage.JOINTS, q)
            F = (bent - q)[:, :, column].reshape(len(part), k, -1)
            b = F @ slope
            imitated = F @ shared
            A = (F * own) @ np.swapaxes(F, 1, 2) - imitated @ np.swapaxes(imitated, 1, 2)
            scale = np.trace(A, axis1=1, axis2=2)[:, None, None] / k
            A = A + 1e-6 * scale * np.eye(k) + 1e-12 * np.eye(k)
            gains.append(np.einsum("gk,gk->g", b, np.linalg.solve(A, b[..., None])[..., 0]))
        return grid[[int(np.argmax(np.concatenate(gains)))]]


def library(kinds: Sequence[type[Effect]], dataset: Dataset) -> list[CandidateEffect]:
    """Every effect at every place that the data set has for it."""
    return [CandidateEffect(kind, where) for kind in kinds for where in kind.locations(dataset)]
