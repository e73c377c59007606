"""How far the model is off on poses that it was not fitted to."""

from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.calibration.result import rms
from robolaser.diagnosis.averaging import AveragedData
from robolaser.diagnosis.penalized_fit import Fit
from robolaser.estimation.folds import FOLDS

RESAMPLES = 2000
STEPS = 4
"""Gauss-Newton steps of each fit without a fold, from the fit to all: a tenth of the poses moves little."""
SHORTER = 0.3
"""Share of a step that is tried next where it did not lower the misfit."""
REACHED = 1e-3
"""Chi-squared promised by a further step, below which the optimum is reached."""
UNFINISHED = 0.3
"""Chi-squared that one more step would still promise, beyond which the derivatives are worked out anew."""


def folds(data: AveragedData, seed: int) -> Ints:
    """The fold in which each pose is held out, (n,); sockets are held out whole, with those at known distances."""
    dataset = data.dataset
    fold = np.zeros(len(dataset.poses), dtype=np.int64)
    if dataset.kind == "socket":
        whole = {name: name for name in dict.fromkeys(dataset.points.names)}
        for one, other, _ in dataset.distances_m:
            old, new = whole.get(other, other), whole.get(one, one)
            whole = {name: new if group == old else group for name, group in whole.items()}
        groups = list(dict.fromkeys(whole.values()))
        if len(groups) > 1:
            order = {group: i for i, group in enumerate(groups)}
            for pose, name in zip(dataset.points.pose, dataset.points.names, strict=True):
                fold[pose] = order[whole[name]] % FOLDS
            return fold
    shuffled = np.random.default_rng(seed).permutation(np.unique(dataset.points.pose))
    fold[shuffled] = np.arange(len(shuffled)) % FOLDS
    return fold


def held_out_errors(fit: Fit, fold_of_pose: Ints) -> Array:
    """Errors of each row by the parameters that the other folds give, (m, 3) [m].

    A socket that is held out is located from its own poses: its errors are those from their mean.
    """
    problem, dataset = fit.problem, fit.problem.model.dataset
    fold = fold_of_pose[dataset.points.pose]
    errors = np.empty((len(fold), 3))
    numbers = np.unique(fold)
    predicted = problem.residuals(_without(fit, np.repeat(fold, 3) != numbers[:, None]))
    for number, rows in zip(numbers, predicted, strict=True):
        errors[fold == number] = rows[fold == number]
    if any(name.startswith("socket.") for name in problem.parameters.names):
        names = np.array(dataset.points.names)
        for name in dict.fromkeys(dataset.points.names):
            errors[names == name] -= errors[names == name].mean(axis=0)
    return errors


@final
class HeldOut:
    """Held-out errors of fits, worked out once for each.

    Args:
        fold_of_pose: The fold in which each pose is held out, (n,).
    """

    def __init__(self, fold_of_pose: Ints) -> None:
        self._fold_of_pose = fold_of_pose
        self._known: dict[int, tuple[Fit, Array]] = {}

    def errors(self, fit: Fit) -> Array:
        """Of each row, (m, 3) [m]."""
        if id(fit) not in self._known:
            self._known[id(fit)] = fit, held_out_errors(fit, self._fold_of_pose)
        return self._known[id(fit)][1]

    def gap(self, fit: Fit) -> float:
        """Their root mean square [m]."""
        return rms(self.errors(fit))


def _without(fit: Fit, kept: Bools) -> Array:
    """Parameters fitted to some whitened residuals only, (f, k) -> (f, d), all at once.

    By Gauss-Newton steps whose derivatives are those of the fit to all; where these do not reach the optimum, by a fit
    of its own.
    """
    problem, J = fit.problem, fit.J
    d = len(fit.x)
    curvature = np.stack([J[rows].T @ J[rows] + np.eye(d) for rows in kept])

    def misfit(x: Array) -> tuple[Array, Array]:
        rows, penalty = kept * problem(x), problem.penalty(x)
        cost = (rows**2).sum(axis=1) + (penalty**2).sum(axis=1)
        return np.where(np.isfinite(cost), cost, np.inf), (rows @ J + penalty) * ~fit.active

    x = np.repeat(fit.x[None], len(kept), axis=0)
    cost, slope = misfit(x)
    length = np.ones(len(kept))
    for _ in range(STEPS):
        steps = -np.linalg.solve(curvature, slope[..., None])[..., 0] * length[:, None]
        if (np.abs((steps * slope).sum(axis=1)) < REACHED).all():
            break
        tried = problem.within(x + problem.prior * steps)
        tried_cost, tried_slope = misfit(tried)
        better = tried_cost < cost
        length = np.where(better, 1.0, SHORTER * length)
        x, cost, slope = (
            np.where(better[:, None], tried, x),
            np.where(better, tried_cost, cost),
            np.where(better[:, None], tried_slope, slope),
        )
    promised = np.einsum("kd,kd->k", slope, np.linalg.solve(curvature, slope[..., None])[..., 0])
    for i in np.flatnonzero(promised > UNFINISHED):
        x[i] = problem.fit(x[i], weight=kept[i].astype(np.float64), steps=STEPS).x
    return x


def interval(errors: Array, pose: Ints, seed: int) -> tuple[float, float]:
    """The gap's 95 % interval, by resampling poses [m]."""
    squares = (errors**2).sum(axis=-1)
    seen, number = np.unique(pose, return_inverse=True)
    total, count = np.bincount(number, squares), np.bincount(number)
    drawn = np.random.default_rng(seed).multinomial(len(seen), np.full(len(seen), 1 / len(seen)), RESAMPLES)
    gaps = np.sqrt(drawn @ total / (drawn @ count))
    low, high = np.quantile(gaps, [0.025, 0.975])
    return float(low), float(high)
