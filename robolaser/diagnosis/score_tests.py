"""Score tests (Rao 1948): how much each candidate effect would explain, before anything is fitted again."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.effect_columns import Columns, prior_scales
from robolaser.diagnosis.fit import Fit, best_amplitudes
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.noise.whitening import group_sums
from robolaser.model.stages import Stage

DENSE_GRID = 40
"""Values of nonlinear parameters, beyond which an effect on a joint is tried by way of the joint's free motions, and
any other in ever smaller intervals."""
NEGLIGIBLE = 1e-8
"""Share of the squared length of an effect's column, below which the fitted parameters imitate it."""


@final
@dataclass(frozen=True)
class ScoreTest:
    """A candidate effect against a fitted model, its nonlinear parameters fixed.

    Attributes:
        candidate_effect: Which.
        nonlinear: Its nonlinear parameters.
        white: Derivatives of the whitened residuals by its linear parameters in units of their prior scales, (K, a).
        products: Of these, without what the fitted parameters imitate, and of q parameters on their way back from a
            bound, with each other and with the residuals, (a + q, a + q + 1).
        against: The fitted model.
        tried: Number of values of the nonlinear parameters that were tried.
    """

    candidate_effect: CandidateEffect
    nonlinear: tuple[float, ...]
    white: Array
    products: Array
    against: Fit
    tried: int

    @property
    def key(self) -> tuple[str, str, tuple[float, ...]]:
        """What it tests: effect, location and nonlinear parameters."""
        return self.candidate_effect.effect.name, self.candidate_effect.where, self.nonlinear

    @cached_property
    def columns(self) -> Array:
        """The derivatives without what the fitted parameters imitate, above those of distances and priors, (K+e, a)."""
        return self.against.at.project(self.white)

    @cached_property
    def basis(self) -> Array:
        """Orthonormal basis of the columns, as far as the parameters do not imitate them, (K + e, a')."""
        U, s, _ = np.linalg.svd(self.columns, full_matrices=False)
        size = float((self.white**2).sum(axis=0).max(initial=0.0))
        kept: Array = U[:, s**2 > NEGLIGIBLE * max(size, 1e-12)]
        return kept

    @cached_property
    def gain(self) -> float:
        """By how much the effect would lower chi-squared, as far as the model is linear.

        Parameters on a bound leave it where the effect makes them; linear parameters that physics permits one sign only
        have no other.
        """
        one_sided = np.array([amplitude.lower == 0 for amplitude in self.candidate_effect.effect.amplitudes()])
        own, released = np.arange(len(one_sided)), np.arange(len(one_sided), len(self.products))
        while True:
            both = np.concatenate([own, released])
            amplitudes = self._best_amplitudes(both)
            if (amplitudes[len(own) :] < 0).any():
                both, amplitudes = own, self._best_amplitudes(own)
            wrong = one_sided[own] & (amplitudes[: len(own)] < 0)
            if not wrong.any():
                break
            own = own[~wrong]
        return -float(amplitudes @ (self.products[np.ix_(both, both)] @ amplitudes + 2.0 * self.products[both, -1]))

    def _best_amplitudes(self, some: Ints) -> Array:
        return best_amplitudes(self.products[np.ix_(some, some)], self.products[some, -1])


def score_tests(fit: Fit, effects: Iterable[CandidateEffect], known: Columns | None = None) -> list[ScoreTest]:
    """Test each effect that a model does not hold, with those nonlinear parameters that explain the residuals best.

    Args:
        fit: The model.
        effects: Candidates.
        known: Derivatives at models near by.
    """
    known = known or Columns()
    motions = JointMotions(fit, known)
    found = []
    for one in effects:
        if one in fit.effects:
            continue
        grid = one.effect.grid(fit.model.dataset, one.where)
        tried = len(grid)
        if tried > DENSE_GRID and one.effect.stage is Stage.JOINTS:
            grid = motions.best_nonlinear(one, grid)
        elif tried > DENSE_GRID and grid.shape[1] == 1:
            grid = _nested(fit, one, grid, known)
        found.append(_best(fit, one, grid, tried, known))
    return found


def typical_tests(fit: Fit, effects: Iterable[CandidateEffect]) -> list[ScoreTest]:
    """The same where nothing is measured: nonlinear parameters are in the middle of what would be tried."""
    known, found = Columns(), []
    for one in effects:
        grid = one.effect.grid(fit.model.dataset, one.where)
        found.append(_best(fit, one, grid[[len(grid) // 2]], len(grid), known))
    return found


def retest(test: ScoreTest, fit: Fit) -> ScoreTest:
    """The same effect with the same nonlinear parameters, against another model."""
    return _best(fit, test.candidate_effect, np.array([test.nonlinear]), test.tried, Columns())


def _nested(fit: Fit, candidate_effect: CandidateEffect, grid: Array, known: Columns) -> Array:
    """The part around the best value of one nonlinear parameter's sorted grid (g, 1), by ever denser grids, (g', 1)."""
    while len(grid) > DENSE_GRID:
        step = -(-len(grid) // (DENSE_GRID // 2))
        coarse = grid[::step]
        best = _best(fit, candidate_effect, coarse, len(grid), known).nonlinear[0]
        at = int(np.flatnonzero(coarse[:, 0] == best)[0]) * step
        grid = grid[max(0, at - step) : at + step + 1]
    return grid


def _best(fit: Fit, candidate_effect: CandidateEffect, grid: Array, tried: int, known: Columns) -> ScoreTest:
    white, a = known.by_effect(fit, candidate_effect, grid), len(prior_scales(candidate_effect))
    products = _products(fit, white, known.squares(fit, candidate_effect, grid))
    options = [
        ScoreTest(candidate_effect, tuple(values), white[:, i * a : (i + 1) * a], products[i], fit, tried)
        for i, values in enumerate(grid.tolist())
    ]
    if len(options) == 1:
        return options[0]
    along = products[:, :, -1]
    at_most = (along[:, None] @ np.linalg.pinv(products[:, :, :-1], hermitian=True) @ along[..., None])[:, 0, 0]
    order = np.argsort(-at_most, kind="stable")
    best: ScoreTest = options[order[0]]
    for i in order[1:]:
        if at_most[i] <= best.gain:
            break
        best = max(best, options[i], key=lambda option: option.gain)
    return best


def _products(fit: Fit, white: Array, squares: Array) -> Array:
    """See `ScoreTest.products`, of effects whose columns (K, g a) have products (g, a, a), (g, a + q, a + q + 1)."""
    (g, a, _), K, release = squares.shape, len(white), fit.release
    imitated = (white.T @ fit.at.Q[:K]).reshape(g, a, -1)
    q = release.shape[1]
    found = np.empty((g, a + q, a + q + 1))
    found[:, :a, :a] = squares - imitated @ np.swapaxes(imitated, 1, 2)
    found[:, :a, a:-1] = (white.T @ release[:K]).reshape(g, a, q)
    found[:, a:, :a] = np.swapaxes(found[:, :a, a:-1], 1, 2)
    found[:, a:, a:-1] = release.T @ release
    found[:, :a, -1] = (white.T @ fit.left[:K]).reshape(g, a)
    found[:, a:, -1] = release.T @ fit.left
    return found


@final
class JointMotions:
    """Free small motions of each joint, one for each pose: every perturbation of a joint is a sum of them."""

    def __init__(self, fit: Fit, known: Columns) -> None:
        self._fit, self._known = fit, known
        self._normal: dict[str, tuple[Array, Array]] = {}

    def _sums(self, joint: str) -> tuple[Array, Array]:
        """Of the products of each pose's motion with the residuals (n,), and with what the parameters can do (n, d)."""
        if joint not in self._normal:
            fit, columns = self._fit, self._known.by_joint(self._fit, joint)
            both = np.column_stack([fit.left, fit.at.Q])[: len(columns)]
            summed = group_sums(columns[:, None] * both, fit.pose_of_number)
            summed = np.pad(summed, ((0, len(fit.model.dataset.poses) - len(summed)), (0, 0)))
            self._normal[joint] = summed[:, 0], summed[:, 1:]
        return self._normal[joint]

    def best_nonlinear(self, candidate_effect: CandidateEffect, grid: Array) -> Array:
        """The most promising of its nonlinear parameters (g, s), (1, s)."""
        gradient, shared = self._sums(candidate_effect.where)
        moves, own = self._known.own_moves(self._fit, candidate_effect, grid)
        (g, a, _), flat = moves.shape, moves.reshape(-1, len(gradient))
        b, imitated = (flat @ gradient).reshape(g, a), (flat @ shared).reshape(g, a, -1)
        A = own - imitated @ np.swapaxes(imitated, 1, 2)
        scale = np.trace(A, axis1=1, axis2=2)[:, None, None] / a
        A = A + 1e-6 * scale * np.eye(a) + 1e-12 * np.eye(a)
        gains = np.einsum("ga,ga->g", b, np.linalg.solve(A, b[..., None])[..., 0])
        return grid[[int(np.argmax(gains))]]


def library(kinds: Sequence[type[Effect]], dataset: Dataset) -> list[CandidateEffect]:
    """Every effect at every location that the data set has for it."""
    return [CandidateEffect(kind, where) for kind in kinds for where in kind.locations(dataset)]
