"""Cross-validation: poses in folds, each predicted by a fit of the others. All held-out errors are computed here."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.estimation.plain_fit import gradients, sampled, solve_corrected
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import MOST_STEPS, solve
from robolaser.model.forward_model import Model, with_rows

FOLDS = 10
FEWEST = 3  # groups of poses; fewer cannot be held out, since the rest fits anything
ALIKE = 1e-4  # [rad, m] Configurations that differ by less are copies of each other
TOLERANCE = 1e-8  # of a fit without one fold, as a share of its cost: predictions then change by less than a thousandth
SAMPLE = 10_000  # rows on which these fits of large data are made
FEW_STEPS = 3
"""Of a fit without one fold that need not be exact: further steps follow a direction that the other folds hardly see.
Held-out errors after 3, 4 and 8 steps are 0.347 mm for a tracked arm, 1.168 mm for a real scanner; 2 steps without
acceleration end so near the fit of all rows that the scanner seems to have 0.774 mm."""

ONE_GROUP = (
    "There is only one socket, which cannot be held out: the error on new poses is that of poses in this socket, which"
    " the others locate. Measure poses in a second one."
)
DIVIDED = (
    "Known distances connect all sockets, so that none can be held out with all those connected to it: each is held out"
    " alone or with its nearest neighbour, and {} known distances lead from sockets that are held out to others."
)
COPIES = (
    "{} poses repeat the configuration of another pose. They are held out together with it, since a pose is no test"
    " of the prediction of its own copy."
)


@final
@dataclass(frozen=True, eq=False)
class Folds:
    """Which rows are held out together."""

    of_row: Ints  # number of each row's fold, (m,)
    whole: bool = False  # whether folds are the sensor's groups of rows: what only these locate is located from them
    warnings: tuple[str, ...] = ()  # why rows are not held out as they should be, and which poses are copies

    @property
    def count(self) -> int:
        """How many folds there are."""
        return int(self.of_row.max()) + 1


def assign_folds(model: Model, seed: int) -> Folds | None:
    """Assign rows to folds, whole poses always; None where there are too few poses.

    Poses of equal configuration share a fold. Larger groups that the sensor holds out together (whole sockets, with
    those at known distances from them) share one too; a warning names exceptions. The seed shuffles the poses.
    """
    dataset = model.dataset
    of_pose, groups = dataset.points.pose, model.blocks.held_out_groups
    if groups is not None and groups.max() > 0:
        return Folds(groups % FOLDS, whole=True, warnings=_divided(dataset, groups))
    number, copies = _configurations(dataset)
    seen = np.unique(number[np.unique(of_pose)])
    if len(seen) < FEWEST:
        return None
    fold = np.full(len(dataset.poses), -1, dtype=np.int64)
    fold[np.random.default_rng(seed).permutation(seen)] = np.arange(len(seen)) % min(FOLDS, len(seen))
    warnings = [] if groups is None else [ONE_GROUP]
    warnings += [COPIES.format(copies)] if copies else []
    return Folds(fold[number[of_pose]], warnings=tuple(warnings))


def _divided(dataset: Dataset, groups: Ints) -> tuple[str, ...]:
    """Warnings where points at a known distance from each other are held out separately."""
    session = dataset.session_of_pose[dataset.points.pose].tolist()
    group = dict(zip(zip(session, dataset.points.names, strict=True), groups.tolist(), strict=True))
    apart = sum(
        len({group[one, point] for point in pair[:2] if (one, point) in group}) > 1
        for one in set(session)
        for pair in dataset.distances_m
    )
    return (DIVIDED.format(apart),) if apart else ()


def _configurations(dataset: Dataset) -> tuple[Ints, int]:
    """The first pose of each pose's configuration, (n,), and how many poses with points repeat an earlier one."""
    poses = dataset.poses
    values = dataset.flange().reshape(len(poses), -1) if poses.q is None else poses.q
    _, first, number = np.unique((values / ALIKE).round(), axis=0, return_index=True, return_inverse=True)
    first_of_pose = _joined(values, np.sort(first))[first[number.reshape(-1)]]
    seen = np.unique(dataset.points.pose)
    return first_of_pose, len(seen) - len(np.unique(first_of_pose[seen]))


def _joined(values: Array, some: Ints) -> Ints:
    """The first configuration (n, j) that each is a copy of, (n,): copies may differ by rounding."""
    along = np.random.default_rng(0).uniform(-1.0, 1.0, values.shape[1])
    order = some[np.argsort(values[some] @ along / np.abs(along).sum(), kind="stable")]
    place, values, pairs = values[order] @ along / np.abs(along).sum(), values[order], []
    for ahead in range(1, len(order)):
        near = np.flatnonzero(place[ahead:] - place[:-ahead] <= ALIKE)
        if not len(near):
            break
        near = near[np.abs(values[near + ahead] - values[near]).max(axis=1) < ALIKE]
        pairs += np.sort([order[near], order[near + ahead]], axis=0).T.tolist()
    joined = np.arange(some.max(initial=0) + 1)
    for one, other in sorted(pairs):
        if joined[one] == one and joined[other] == other:
            joined[other] = one
    return joined


@final
@dataclass(frozen=True, eq=False)
class FoldFits:
    """The fits without each fold, and their predictions."""

    errors: Array  # residuals of each row by the fit without its fold, in the sensor's unit, (m, k)
    of_row: Ints  # the fold of each row, (m,)
    x: Array  # the parameters of each of these fits, (f, d)
    evaluations: int  # residual vectors evaluated


def held_out(problem: Problem, x: Array, folds: Folds, *, enough: float = 0.0, slopes: Array | None = None) -> FoldFits:
    """Predict each fold by a fit of all the others.

    Each fit starts from the problem's optimum x (d,), and may miss its optimum by the cost `enough`, see `solve`.
    Large data are fitted on a sample of their rows that has the gradient of all of them.
    Derivatives there, `slopes` (d, K), save their first evaluation.
    """
    sample = sampled(problem, SAMPLE)
    if sample is None:
        fits, evaluations = _fits(problem, x, folds, enough, slopes)
    else:
        fits, evaluations = _by_sample(problem, x, folds, sample)
    errors = _predicted(problem, fits, folds)
    if folds.whole:
        errors = problem.model.blocks.relocated(errors)
    return FoldFits(errors, folds.of_row, fits, evaluations + folds.count)


def _fits(problem: Problem, x: Array, folds: Folds, enough: float, slopes: Array | None) -> tuple[Array, int]:
    """Fits without each fold, (f, d), and the residual vectors evaluated."""
    starts, kept = np.tile(x, (folds.count, 1)), folds.of_row != np.arange(folds.count)[:, None]
    end = solve(
        problem,
        starts,
        kept=kept,
        tol=TOLERANCE,
        enough=max(enough, TOLERANCE * float(problem.costs(x[None])[0])),
        most_steps=FEW_STEPS if enough else MOST_STEPS,
        slopes=slopes,
        close=enough > 0.0,
    )
    return end.x, end.evaluations


def _predicted(problem: Problem, fits: Array, folds: Folds) -> Array:
    """Residuals of each row by the fit (f, d) without its fold, (m, k)."""
    if len(problem.batches) == 1:
        return problem.plain(fits)[folds.of_row, np.arange(problem.rows)]
    errors = np.empty((problem.rows, problem.model.blocks.numbers))
    for fold in range(folds.count):
        mine = np.flatnonzero(folds.of_row == fold)
        errors[mine] = with_rows(problem.model, mine).residuals(fits[[fold]])[0]
    return errors


def _by_sample(problem: Problem, x: Array, folds: Folds, sample: tuple[Problem, Ints]) -> tuple[Array, int]:
    """The same on a sample of the rows, each fit with the gradient of all its rows."""
    some, rows = sample
    of_fold, counts = gradients(problem, x, folds.of_row), np.bincount(folds.of_row)
    ends = [
        solve_corrected(
            some,
            x,
            (of_fold.sum(axis=0) - of_fold[fold]) / (problem.rows - counts[fold]),
            kept=folds.of_row[rows] != fold,
            tol=TOLERANCE,
        )
        for fold in range(folds.count)
    ]
    evaluations = sum(end.evaluations for end in ends) + len(x) + 1
    return np.concatenate([end.x for end in ends]), evaluations
