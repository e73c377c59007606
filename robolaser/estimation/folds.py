"""Cross-validation: poses in folds, each predicted by a fit of all the others. Every held-out error comes from here."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset
from robolaser.estimation.bounded_step import bounded_steps
from robolaser.estimation.problem import Problem
from robolaser.estimation.sample_fit import gradients, sampled, solve_corrected
from robolaser.estimation.solver import LEAST_DAMPING, solve
from robolaser.model.batches import with_rows
from robolaser.model.forward_model import Model

FOLDS = 10
FEWEST = 3  # groups of poses; fewer cannot be held out, since what is left fits anything
ALIKE = 1e-4  # [rad, m] Configurations that differ by less are copies of each other
TOLERANCE = 1e-8
"""Of a fit without one fold, as a share of its cost: predictions then change by less than their thousandth part."""
SAMPLE = 10_000  # rows on which these fits of large data are made
MOST_STEPS = 8
"""Of a fit without one fold that need not be exact: beyond, it follows a valley that the others hardly see. On held-out
poses of a tracked arm 2, 4, 8 and 30 steps gave 0.448, 0.448, 0.454 and 0.455 mm, of a real scanner 20, 50 and 644
steps 0.460, 0.466 and 0.463 mm."""
CHORDS, SHORTER = 8, 0.3
"""Steps of all those fits with the derivatives of the fit to all poses: a tenth of the poses moves little. A step that
does not lower the cost is tried again, shorter."""

ONE_GROUP = (
    "There is only one socket, which cannot be held out: the error on new poses is that of poses in this socket, which"
    " the others locate. Poses in a second one would tell more."
)
DIVIDED = (
    "Known distances connect all sockets, so that none can be held out with all those connected to it: each is held out"
    " alone or with its nearest neighbour, and {} known distances lead from sockets that are held out to others."
)


@final
@dataclass(frozen=True, eq=False)
class Folds:
    """Which rows are held out together."""

    of_row: Ints  # number of each row's fold, (m,)
    # whether folds are the sensor's groups of rows: whatever only these rows locate is located from them
    whole: bool = False
    copies: int = 0  # how many poses repeat another pose's configuration
    remark: str = ""  # why rows are not held out as they should be

    @property
    def count(self) -> int:
        """How many folds there are."""
        return int(self.of_row.max()) + 1

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the user should know."""
        remarks = (self.remark,) if self.remark else ()
        if not self.copies:
            return remarks
        return (
            *remarks,
            f"{self.copies} poses repeat the configuration of another pose. They are held out together with it, since "
            "a pose says nothing about how well its own copy is predicted.",
        )


def assign_folds(model: Model, seed: int) -> Folds | None:
    """Assign rows to folds, whole poses always; None where there are too few poses.

    Poses of equal configuration share a fold. Where the sensor holds out more than poses together (sockets: whole
    sockets, with those at known distances from them), so does this, and a remark says where it cannot.

    Args:
        model: Data and sensor.
        seed: Shuffles the poses.
    """
    dataset = model.dataset
    of_pose, groups = dataset.points.pose, model.blocks.held_out_groups
    if groups is not None and groups.max() > 0:
        return Folds(groups % FOLDS, whole=True, remark=_divided(dataset, groups))
    number, copies = _configurations(dataset)
    seen = np.unique(number[np.unique(of_pose)])
    if len(seen) < FEWEST:
        return None
    fold = np.full(len(dataset.poses), -1, dtype=np.int64)
    fold[np.random.default_rng(seed).permutation(seen)] = np.arange(len(seen)) % min(FOLDS, len(seen))
    return Folds(fold[number[of_pose]], copies=copies, remark="" if groups is None else ONE_GROUP)


def _divided(dataset: Dataset, groups: Ints) -> str:
    """What to know where points at a known distance from each other are held out apart; "" where none are."""
    session = dataset.session_of_pose[dataset.points.pose].tolist()
    group = dict(zip(zip(session, dataset.points.names, strict=True), groups.tolist(), strict=True))
    apart = sum(
        len({group[one, point] for point in pair[:2] if (one, point) in group}) > 1
        for one in set(session)
        for pair in dataset.distances_m
    )
    return DIVIDED.format(apart) if apart else ""


def _configurations(dataset: Dataset) -> tuple[Ints, int]:
    """The first pose of each pose's configuration, (n,), and how many poses with points repeat an earlier one."""
    poses = dataset.poses
    values = dataset.flange().reshape(len(poses), -1) if poses.q is None else poses.q
    _, first, number = np.unique((values / ALIKE).round(), axis=0, return_index=True, return_inverse=True)
    first_of_pose: Ints = first[number.reshape(-1)]
    seen = np.unique(dataset.points.pose)
    return first_of_pose, len(seen) - len(np.unique(first_of_pose[seen]))


@final
@dataclass(frozen=True, eq=False)
class FoldFits:
    """What fits without each fold say."""

    errors: Array  # residuals of each row by the fit without its fold, in the sensor's unit, (m, k)
    x: Array  # the parameters of each of these fits, (f, d)
    evaluations: int  # residual vectors evaluated


def held_out(
    problem: Problem, x: Array, folds: Folds, *, enough: float = 0.0, slopes: Array | None = None, amid: int = 0
) -> FoldFits:
    """Predict each fold by a fit of all the others.

    Each fit starts from the parameters that all rows gave, and takes steps with their derivatives there. Where such a
    step still promises something, the fit goes on by the solver; or, where it need not be exact, with derivatives amid
    all fits that go on. Large data are fitted on a sample of their rows that has the gradient of all of them.

    Args:
        problem: What was minimised.
        x: Its optimum, (d,).
        folds: Which rows are held out together.
        enough: Cost that each of the fits may be above its optimum, in its own unit; see `solve`.
        slopes: Derivatives of the residuals there by each parameter over its scale, where they are known, (K, d).
        amid: How often derivatives are taken anew, amid the fits that go on, in place of the solver.
    """
    sample = sampled(problem, SAMPLE)
    if sample is None:
        unmoved = np.zeros((folds.count, len(x)))
        fits, going, evaluations = _by_chords(problem, x, folds.of_row, unmoved, enough, slopes)
        for _ in range(amid):
            if not len(going):
                break
            middle = fits[going].mean(axis=0)
            fits, going, more = _by_chords(problem, middle, folds.of_row, unmoved, enough, start=(fits, going))
            evaluations += more
        if len(going) and not amid:
            kept, hopeless = folds.of_row != going[:, None], _many_steps if enough else None
            ends = solve(problem, fits[going], kept=kept, tol=TOLERANCE, enough=enough, hopeless=hopeless)
            fits[going], evaluations = ends.x, evaluations + ends.evaluations
    else:
        fits, evaluations = _by_sample(problem, x, folds, sample)
    errors = _predicted(problem, fits, folds)
    if folds.whole:
        errors = problem.model.blocks.located_apart(errors)
    return FoldFits(errors, fits, evaluations + folds.count)


def _many_steps(cost: Array, converged: Bools, steps: Ints) -> Bools:
    return np.asarray(steps >= MOST_STEPS)


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
    """Fits without each fold (f, d) on a sample of the rows, each with the gradient of all rows that it keeps."""
    some, rows = sample
    of_row = folds.of_row[rows]
    others = 1.0 - np.eye(folds.count)
    of_all = others @ gradients(problem, x, folds.of_row, folds.count)
    shares = (others @ np.bincount(of_row, minlength=folds.count)) / (
        others @ np.bincount(folds.of_row, minlength=folds.count)
    )
    lacking = shares[:, None] * of_all - others @ gradients(some, x, of_row, folds.count)
    fits, going, evaluations = _by_chords(some, x, of_row, lacking)
    evaluations += 2 * (len(x) + 1)
    for fold in going:
        kept = folds.of_row != fold
        mean = of_all[fold] / np.count_nonzero(kept)
        end = solve_corrected(some, x, mean, kept=kept[rows], tol=TOLERANCE)
        fits[fold], evaluations = end.x[0], evaluations + end.evaluations
    return fits, evaluations


def _slopes(problem: Problem, x: Array, known: Array | None) -> Callable[[int], Array]:
    """Derivatives of each batch's numbers at x, (d, K); kept where they are few, else worked out when they are used."""
    if known is not None and len(problem.batches) == 1:
        return lambda _: known.T

    def of_batch(i: int) -> Array:
        return np.asarray(problem.batches[i][1].jacobian(x[None])[0])

    return cache(of_batch) if len(problem.batches) == 1 or problem.rows <= SAMPLE else of_batch


def _by_chords(
    problem: Problem,
    x: Array,
    of_row: Ints,
    lacking: Array,
    enough: float = 0.0,
    slopes: Array | None = None,
    start: tuple[Array, Ints] | None = None,
) -> tuple[Array, Ints, int]:
    """Fits without each fold by steps with the derivatives of all rows at x.

    Args:
        problem: What to minimise.
        x: Where its derivatives are taken, (d,).
        of_row: Fold of each row, (m,).
        lacking: What is added to the gradient of the others of each fold, by each parameter over its scale, (f, d).
        enough: See `held_out`.
        slopes: Likewise.
        start: Where the fits are, (f, d), and the folds whose fits go on; when absent all, from x.

    Returns:
        The parameters (f, d), the folds whose fits should go on, and the residual vectors evaluated.
    """
    (f, d), slopes_of = lacking.shape, _slopes(problem, x, slopes)
    others = 1.0 - np.eye(f)
    extra = problem.extra_jacobian(x[None])[0]
    A = np.einsum("gf,fij->gij", others, _normals(problem, x, of_row, f, slopes_of)) + extra @ extra.T
    lengths = np.sqrt(np.einsum("gii->gi", A))
    unit = np.where(lengths > 0.0, lengths, 1.0)
    A = A / unit[:, :, None] / unit[:, None, :] + LEAST_DAMPING * np.eye(d)
    fits, on = (np.repeat(x[None], f, axis=0), np.arange(f)) if start is None else start
    cost, gradient, length, trial, evaluations = np.full(f, np.inf), np.zeros((f, d)), np.ones(f), fits.copy(), d + 1
    for _ in range(CHORDS):
        costs, at_trial = _at(problem, trial[on], of_row, on, slopes_of)
        costs += 2.0 * (lacking[on] * (trial[on] - x) / problem.scale).sum(axis=1)
        evaluations += len(on)
        better = costs < cost[on]
        to = on[better]
        fits[to], cost[to], gradient[to] = trial[to], costs[better], at_trial[better] + lacking[to]
        length[on] = np.where(better, 1.0, SHORTER * length[on])
        room = tuple((end - fits[on]) / problem.scale * unit[on] for end in (problem.lower, problem.upper))
        steps, gains, _ = bounded_steps(A[on], gradient[on] / unit[on], room[0], room[1])
        unfinished = gains > np.maximum(TOLERANCE * cost[on], enough)
        on = on[unfinished]
        if not len(on):
            break
        trial[on] = fits[on] + length[on, None] * problem.scale * (steps[unfinished] / unit[on])
        trial[on] = np.clip(trial[on], problem.lower, problem.upper)
    return fits, on, evaluations


def _normals(problem: Problem, x: Array, of_row: Ints, count: int, slopes_of: Callable[[int], Array]) -> Array:
    """JᵀJ of each fold's rows at x, (f, d, d)."""
    A = np.zeros((count, len(x), len(x)))
    for i, (rows, batch) in enumerate(problem.batches):
        _, J = batch.loss.linearized(batch.residuals(x[None]), slopes_of(i)[None], batch.starts)
        of_number = of_row[rows][batch.row_of_number]
        for fold in np.unique(of_number):
            part = J[0][:, of_number == fold]
            A[fold] += part @ part.T
    return A


def _at(
    problem: Problem, fits: Array, of_row: Ints, folds: Ints, slopes_of: Callable[[int], Array]
) -> tuple[Array, Array]:
    """Cost of the others of some folds (g,) at parameters (g, d), (g,), and its gradient by given slopes, (g, d)."""
    extra = problem.extra_residuals(fits)
    costs = np.square(extra).sum(axis=1)
    gradients = (problem.extra_jacobian(fits) @ extra[..., None])[..., 0]
    for i, (rows, batch) in enumerate(problem.batches):
        of_number = of_row[rows][batch.row_of_number]
        r = batch.residuals(fits) * (of_number != folds[:, None])
        costs = costs + batch.loss.costs(r, batch.starts)
        if not batch.loss.is_square:
            weights = batch.loss.weights(r, batch.starts)
            r = r * np.repeat(weights, np.diff(batch.starts, append=r.shape[1]), axis=1)
        gradients = gradients + r @ slopes_of(i).T
    return costs, gradients
