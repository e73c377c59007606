"""Score tests (Rao 1948): chi-squared that candidate effects would explain, alone or in turn, without a refit."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.checks import different_poses
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.dense_grids import gains_of_steps, gains_of_waves
from robolaser.diagnosis.effect_columns import Columns, prior_scales
from robolaser.diagnosis.fit import Fit, best_amplitudes
from robolaser.diagnosis.penalties import complexity_penalty
from robolaser.diagnosis.thresholds import CHI2_PER_PARAMETER, OPEN_SHARE
from robolaser.estimation.nonlinear_parameters import NEGLIGIBLE
from robolaser.estimation.solver import ENOUGH
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.effects.requirements import DataLack
from robolaser.model.grouped_rows import GroupedRows

DENSE_GRID = 40
"""Number of values of nonlinear parameters above which sums over poses find the best for waves and for effects that
begin at a moment, and ever smaller intervals for other effects; of knots, and of widths of play, of a shape."""


@final
@dataclass(frozen=True)
class ScoreTest:
    """A candidate effect against a fitted model, its nonlinear parameters fixed."""

    candidate_effect: CandidateEffect
    nonlinear: tuple[float, ...]  # values of its nonlinear parameters
    white: Array  # derivatives of whitened residuals by its linear parameters in units of prior scales, (K, a)
    columns: Array  # these, then those of distances and priors, without what fitted parameters imitate, (K + e, a)
    against: Fit  # the fitted model
    tried: int  # number of values of the nonlinear parameters that were tried

    @property
    def key(self) -> tuple[str, str, tuple[float, ...]]:
        """Effect, location and nonlinear parameters."""
        return self.candidate_effect.effect.name, self.candidate_effect.where, self.nonlinear

    @property
    def penalty(self) -> float:
        """The complexity penalty of the effect."""
        return complexity_penalty(freedom(self.candidate_effect.effect, self.tried), self.tried)

    @cached_property
    def basis(self) -> Array:
        """Orthonormal basis of the columns, without directions that the parameters imitate, (K + e, a')."""
        U, s, _ = np.linalg.svd(self.columns, full_matrices=False)
        size = float((self.white**2).sum(axis=0).max(initial=0.0))
        return np.asarray(U[:, s**2 > NEGLIGIBLE * max(size, 1e-12)])

    @cached_property
    def gain(self) -> float:
        """Decrease of chi-squared by the effect in the linear model.

        Parameters on a bound may leave it inwards; one-sided linear parameters keep their sign.
        """
        residuals, columns = self.against.at.r, self.columns
        one_sided = np.array([amplitude.lower == 0 for amplitude in self.candidate_effect.effect.amplitudes()])
        while True:
            both = np.hstack([columns, self.against.release])
            amplitudes = best_amplitudes(both, residuals)
            if (amplitudes[columns.shape[1] :] < 0).any():
                both, amplitudes = columns, best_amplitudes(columns, residuals)
            wrong = one_sided & (amplitudes[: columns.shape[1]] < 0)
            if not wrong.any():
                break
            columns, one_sided = columns[:, ~wrong], one_sided[~wrong]
        after = residuals + both @ amplitudes
        return float(residuals @ residuals - after @ after)


def score_tests(fit: Fit, effects: Iterable[CandidateEffect], known: Columns | None = None) -> list[ScoreTest]:
    """Test each effect outside a model, with the nonlinear parameters that explain the residuals best.

    Derivatives may be known from similar models.
    """
    known = known or Columns()
    found = []
    for one in effects:
        if one in fit.effects:
            continue
        grid = one.effect.grid(fit.model.dataset, one.where)
        tried = len(grid)
        if tried > DENSE_GRID and one.effect.harmonics:
            grid = _likeliest_wave(fit, one, grid[:, 0], known)
        elif tried > DENSE_GRID and one.effect.begins:
            white = known.by_effect(fit, one, np.zeros((1, 1)))
            gains = gains_of_steps(fit, white, fit.model.run.progress_of_all, grid[:, 0])
            grid = grid[[int(np.argmax(gains))]]
        elif tried > DENSE_GRID and grid.shape[1] == 1:
            grid = _nested(fit, one, grid, known)
        found.append(_best(fit, one, grid, tried, known))
    return found


def _likeliest_wave(fit: Fit, wave: CandidateEffect, frequencies: Array, known: Columns) -> Array:
    """The frequency that explains most, (1, 1); twice the frequency if the first harmonic contributes nothing."""
    robot, q = fit.model.dataset.arm
    seen, of_number = np.unique(fit.pose_of_number, return_inverse=True)
    normal = normal_equations(fit, known.by_joint(fit, wave.where), of_number, len(seen))
    angle = q[seen, robot.joints.index(wave.where)]

    def gains(frequencies: Array) -> Array:
        return gains_of_waves(normal, angle, frequencies, wave.effect.harmonics, prior_scales(wave))

    best, step = frequencies[int(np.argmax(gains(frequencies)))], frequencies[1] - frequencies[0]
    if 2.0 * best <= frequencies[-1]:
        near = best + step * np.linspace(-0.5, 0.5, 9)
        single, double = gains(near).max(), gains(2.0 * near).max()
        if single - double < max(2.0 * CHI2_PER_PARAMETER, OPEN_SHARE * single):
            best *= 2.0
    return np.array([[best]])


def typical_tests(fit: Fit, effects: Iterable[CandidateEffect]) -> list[ScoreTest]:
    """Score tests without measurements, with nonlinear parameters in the middle of their grids."""
    known, found = Columns(), []
    for one in effects:
        grid = one.effect.grid(fit.model.dataset, one.where)
        found.append(_best(fit, one, grid[[len(grid) // 2]], len(grid), known))
    return found


def retest(test: ScoreTest, fit: Fit) -> ScoreTest:
    """Test the same effect with the same nonlinear parameters against another model."""
    return _best(fit, test.candidate_effect, np.array([test.nonlinear]), test.tried, Columns())


def _nested(fit: Fit, candidate_effect: CandidateEffect, grid: Array, known: Columns) -> Array:
    """Search a sorted grid (g, 1) of one nonlinear parameter by ever smaller intervals; return the last, (g', 1)."""
    while len(grid) > DENSE_GRID:
        step = -(-len(grid) // (DENSE_GRID // 2))
        coarse = grid[::step]
        best = _best(fit, candidate_effect, coarse, len(grid), known).nonlinear[0]
        at = int(np.flatnonzero(coarse[:, 0] == best)[0]) * step
        grid = grid[max(0, at - step) : at + step + 1]
    return grid


def _best(fit: Fit, candidate_effect: CandidateEffect, grid: Array, tried: int, known: Columns) -> ScoreTest:
    white = known.by_effect(fit, candidate_effect, grid)
    columns = np.asfortranarray(fit.at.project(white))
    unseen = (columns**2).sum(axis=0) < NEGLIGIBLE * np.maximum((white**2).sum(axis=0), 1.0)
    columns[:, unseen] = 0.0  # rounding would explain as much of the noise as any other column
    a = white.shape[1] // len(grid)
    spans = [slice(i * a, (i + 1) * a) for i in range(len(grid))]
    options = [
        ScoreTest(candidate_effect, tuple(values), white[:, span], columns[:, span], fit, tried)
        for values, span in zip(grid.tolist(), spans, strict=True)
    ]
    if len(options) == 1:
        return options[0]
    bounds = _gains_at_most(columns.reshape(len(columns), len(grid), a), fit)
    gains = np.full(len(options), -np.inf)
    for i in np.argsort(-bounds, kind="stable"):
        if bounds[i] < gains.max() - ENOUGH:
            break
        gains[i] = options[i].gain
    return options[int(np.argmax(gains > gains.max() - ENOUGH))]  # the first of equal ones: rounding decides nothing


def _gains_at_most(columns: Array, fit: Fit) -> Array:
    """Upper bounds of the gains of columns (K + e, g, a): those with amplitudes of either sign, (g,)."""
    options = np.moveaxis(columns, 0, 2)
    release = np.broadcast_to(fit.release.T, (len(options), *fit.release.T.shape))
    both = np.concatenate([options, release], axis=1)
    along = both @ fit.at.r
    products = both @ np.swapaxes(both, 1, 2)
    return np.asarray((along[:, None] @ np.linalg.pinv(products, hermitian=True) @ along[..., None])[:, 0, 0])


def normal_equations(fit: Fit, columns: Array, of_number: Ints, n: int) -> tuple[Array, Array, Array]:
    """Normal equations of independent motions, one for each group of whitened numbers, beside the fitted parameters.

    Args:
        fit: The model.
        columns: Derivatives of the whitened residuals by the motion of each number's group, (K,).
        of_number: The group of each number, (K,).
        n: Number of groups.

    Returns:
        Gradient (n,), and own (n,) and shared (n, d) of the matrix diag(own) - shared sharedᵀ.
    """
    Q = fit.at.Q[: len(columns)]
    shared = np.zeros((n, Q.shape[1]))
    rows = GroupedRows(of_number)
    shared[: of_number.max() + 1] = (rows.apart(columns)[:, None] @ rows.apart(Q))[:, 0]
    gradient = np.bincount(of_number, columns * fit.at.white, minlength=n) - shared @ (fit.at.Q.T @ fit.at.r)
    own = np.asarray(np.bincount(of_number, columns**2, minlength=n), dtype=np.float64)
    return gradient, own, shared


def library(kinds: Sequence[type[Effect]], dataset: Dataset) -> list[CandidateEffect]:
    """Every effect at every location that the data set has for it, if enough poses differ."""
    return [
        CandidateEffect(kind, where)
        for kind in kinds
        if not lack_of_poses(kind, dataset)
        for where in kind.locations(dataset)
    ]


def lack_of_poses(kind: type[Effect], dataset: Dataset) -> str:
    """Return why too few poses differ to test an effect of several shapes, the best of which fits by chance; else "".

    Chance explains one pose for each parameter, and as many more as twice the logarithm of the number of shapes.
    """
    tried = max((len(kind.grid(dataset, where)) for where in kind.locations(dataset)), default=0)
    if tried <= 1:
        return ""
    needed = math.ceil(freedom(kind, tried) + 2.0 * math.log(tried))
    if different_poses(dataset, needed) >= needed:
        return ""
    return DataLack(f"fewer than {needed} poses with points differ", f"at least {needed} poses that differ")


def freedom(kind: type[Effect], tried: int) -> int:
    """Number of an effect's parameters; nonlinear ones count if several values were tried."""
    return len(kind.units()) if tried > 1 else len(kind.amplitudes())
