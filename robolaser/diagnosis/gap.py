"""How far the model is off on poses that it was not fitted to."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.diagnosis.fitted import Fitted
from robolaser.diagnosis.observed import Observed
from robolaser.held_out import FOLDS

RESAMPLES = 2000
STEPS = 4
"""Gauss-Newton steps of each fit without a fold, from the fit to all: a tenth of the poses moves little."""


def folds(observed: Observed, seed: int) -> Ints:
    """The group in which each pose is held out, (n,); sockets are held out whole, with those at known distances."""
    dataset = observed.dataset
    n = len(dataset.poses)
    rng = np.random.default_rng(seed)
    if dataset.kind == "socket":
        whole = {name: name for name in dict.fromkeys(dataset.points.names)}
        for one, other, _ in dataset.distances_m:
            old, new = whole.get(other, other), whole.get(one, one)
            whole = {name: new if group == old else group for name, group in whole.items()}
        groups = list(dict.fromkeys(whole.values()))
        if len(groups) > 1:
            order = {group: i for i, group in enumerate(groups)}
            fold = np.zeros(n, dtype=np.int64)
            for pose, name in zip(dataset.points.pose, dataset.points.names, strict=True):
                fold[pose] = order[whole[name]] % FOLDS
            return fold
    fold = np.empty(n, dtype=np.int64)
    seen = np.unique(dataset.points.pose)
    fold[:] = 0
    fold[rng.permutation(seen)] = np.arange(len(seen)) % min(FOLDS, len(seen))
    return fold


def held_out(fitted: Fitted, fold_of_pose: Ints) -> Array:
    """Errors of each row by the parameters that the other folds give, (m, 3) [m].

    A socket that is held out is located from its own poses: its errors are those from their mean.
    """
    problem, dataset = fitted.problem, fitted.problem.model.dataset
    fold = fold_of_pose[dataset.points.pose]
    errors = np.empty((len(fold), 3))
    for k in np.unique(fold):
        out = fold == k
        refitted = problem.fit(fitted.x, weight=np.repeat(~out, 3).astype(np.float64), steps=STEPS)
        errors[out] = problem.plain(refitted.x[None])[0, out]
    if any(name.startswith("socket.") for name in problem.parameters.names):
        names = np.array(dataset.points.names)
        for name in dict.fromkeys(dataset.points.names):
            errors[names == name] -= errors[names == name].mean(axis=0)
    return errors


def rms(errors: Array) -> float:
    """Root-mean-square 3-D error, (m, 3) [m] -> [m]."""
    return float(np.sqrt((errors**2).sum(axis=-1).mean()))


def interval(errors: Array, pose: Ints, seed: int) -> tuple[float, float]:
    """Where the gap lies with 95 % probability, by resampling poses [m]."""
    squares = (errors**2).sum(axis=-1)
    seen, number = np.unique(pose, return_inverse=True)
    total, count = np.bincount(number, squares), np.bincount(number)
    drawn = np.random.default_rng(seed).multinomial(len(seen), np.full(len(seen), 1 / len(seen)), RESAMPLES)
    gaps = np.sqrt(drawn @ total / (drawn @ count))
    low, high = np.quantile(gaps, [0.025, 0.975])
    return float(low), float(high)
