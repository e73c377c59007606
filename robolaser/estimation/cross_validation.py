"""How well a calibration predicts poses that it has not seen."""

from collections.abc import Iterator
from itertools import accumulate
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.estimation.bounded_step import Linear
from robolaser.estimation.gauss_newton import NOISE, bent
from robolaser.estimation.problem import Box, Residuals
from robolaser.estimation.r_factor import triangle
from robolaser.estimation.robust_loss import AXES
from robolaser.estimation.rows import PROBE, bends_along

FOLDS = 10
FEWEST = 3  # poses with points; below, what is left fits anything
TOLERANCE = 1e-6  # of a fold's polish: along a bent valley, where it stops, predictions hardly change


def held_out(residuals: Residuals, x: Array, box: Box, *, seed: int) -> tuple[Array | None, int]:
    """Leave groups of poses out in turn, fit the rest, and predict them.

    Every pose with points is left out once, whole, never a single row: rows of a pose share their errors. Each fit
    starts from the parameters found on all poses.

    Args:
        residuals: Those that were minimised.
        x: The parameters found, (d,).
        box: Where the polish may go.
        seed: Deals the poses into groups.

    Returns:
        Known or measured points less predicted ones, (m, 3) [m], or None with too few poses; and the candidates
        evaluated.
    """
    groups = fold_of_rows(residuals.model.dataset, seed)
    if groups is None:
        return None, 0
    folds = _Folds(residuals, box, groups, x)
    trials, gains = folds.trials()
    errors, costs = folds.predicted(trials)
    evaluations = folds.evaluations + len(trials)
    missed = np.abs((folds.costs - gains) - costs) / np.maximum(costs, np.finfo(np.float64).tiny)
    for fold in np.flatnonzero(~(missed <= TOLERANCE)):
        out = groups == fold
        start = trials[fold] if costs[fold] < folds.costs[fold] else x
        end = box.polish(residuals, start, tol=TOLERANCE, kept=~out)
        errors[out] = residuals.model.residuals(end.x[None])[0, out]
        evaluations += end.evaluations
    return (errors if np.isfinite(errors).all() else None), evaluations


@final
class _Folds:
    """What each group of poses says at the parameters found, worked out once for all groups.

    The first step of a fit without one group is that of the others' triangles put together. Where it brings what it
    promised, the fit has come to its end: with many poses a group moves little.

    Attributes:
        costs: Of all rows but those of each group, at the parameters found, (g,).
        evaluations: Candidates evaluated so far.
    """

    def __init__(self, residuals: Residuals, box: Box, groups: Ints, x: Array) -> None:
        self._residuals, self._groups, self._around = residuals, groups, box.around(x)
        self._count = int(groups.max()) + 1
        self._triangles = [np.empty((0, len(x) + 1))] * self._count
        own = np.zeros(self._count)
        for rows, block in residuals.blocks:
            slopes = self._around.slopes(block, AXES * len(rows))
            straight = block.loss.straightened(slopes)
            for fold, numbers in _numbers_of(groups[rows]):
                own[fold] += block.loss.costs(slopes[-1:, numbers])[0]
                part = triangle(straight[:, numbers].T)
                self._triangles[fold] = triangle(part, self._triangles[fold])
        self.costs = own.sum() - own
        self.evaluations = self._around.evaluations

    def trials(self) -> tuple[Array, Array]:
        """Where a first step takes each fit, (g, d), and by how much it promises to lower its cost, (g,)."""
        at, undamped = self._around, np.zeros(1)
        models = [(Linear(R[:, :-1], NOISE), R[:, -1]) for R in _all_but_one(self._triangles)]
        straight = [model.steps(r, *at.room, undamped) for model, r in models]
        steps, gains = (np.concatenate(parts) for parts in zip(*straight, strict=True))
        pulls = self._pulls(steps)
        turned = [bent(model, r, steps[[i]], pulls[[i]], at.room, undamped) for i, (model, r) in enumerate(models)]
        return at.moved(np.concatenate(turned)), gains

    def _pulls(self, steps: Array) -> Array:
        """Where the second derivatives of each fit's rows along its step pull, (g, d)."""
        at = self._around
        probes = at.moved(PROBE * steps)
        pulls = np.zeros_like(steps)
        for rows, block in self._residuals.blocks:
            slopes = at.slopes(block, AXES * len(rows))
            bends = bends_along(block, block.loss, slopes, steps, probes)
            for fold, numbers in _numbers_of(self._groups[rows]):
                bends[fold, numbers] = 0.0
            pulls += bends @ slopes[:-1].T
        self.evaluations += at.evaluations + len(steps)
        return np.where(np.isfinite(pulls).all(axis=1, keepdims=True), pulls, 0.0)

    def predicted(self, candidates: Array) -> tuple[Array, Array]:
        """Each row predicted by its group's candidate (g, d): errors (m, 3) [m]; and what the others cost it, (g,)."""
        errors, costs = np.empty((len(self._groups), AXES)), np.zeros(self._count)
        for rows, block in self._residuals.blocks:
            plain = block.model.residuals(candidates)
            seen = block.whitened(plain)
            costs += block.loss.costs(seen)
            for fold, numbers in _numbers_of(self._groups[rows]):
                of_fold = numbers[::AXES] // AXES
                errors[rows[of_fold]] = plain[fold, of_fold]
                with np.errstate(invalid="ignore"):  # infinite ones
                    costs[fold] -= block.loss.costs(seen[fold : fold + 1, numbers])[0]
        return errors, costs


def _all_but_one(triangles: list[Array]) -> Iterator[Array]:
    """The triangle of all the others, for each: of those before it and those after it."""
    after = list(accumulate(reversed(triangles[1:]), lambda below, above: triangle(above, below)))[::-1]
    before = triangles[0][:0]
    for own, others in zip(triangles, [*after, before], strict=True):
        yield triangle(others, before)
        before = triangle(own, before)


def _numbers_of(groups: Ints) -> Iterator[tuple[int, Ints]]:
    """Groups of rows (m,), and which of their 3m numbers are theirs."""
    numbers = np.arange(AXES * len(groups)).reshape(-1, AXES)
    for group in np.unique(groups):
        yield int(group), numbers[groups == group].ravel()


def fold_of_rows(dataset: Dataset, seed: int) -> Ints | None:
    """The group in which each row is left out, (m,); None with too few poses.

    Poses are dealt in turn from each socket, or each set of reflectors, so that none is left out altogether.
    """
    points = dataset.points
    seen = np.unique(points.pose)
    if len(seen) < FEWEST:
        return None
    shuffled = np.random.default_rng(seed).permutation(seen)
    if dataset.kind == "socket":
        socket = dict(zip(points.pose.tolist(), points.names, strict=True))
        shuffled = np.array(sorted(shuffled, key=lambda pose: socket[int(pose)]))
    group_of_pose = np.full(len(dataset.poses), -1)
    group_of_pose[shuffled] = dealt(len(shuffled))
    return group_of_pose[points.pose].astype(np.int64)


def dealt(count: int) -> Ints:
    """The group that each of so many poses gets when they are dealt in turn, (count,)."""
    return np.arange(count, dtype=np.int64) % min(FOLDS, count)
