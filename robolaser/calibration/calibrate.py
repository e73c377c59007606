"""Parameters from data: a global search, a least-squares fit, and the uncertainty of the result."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from robolaser.arrays import Array, Bools, Progress
from robolaser.calibration.checks import check_orientations, check_poses, check_target, setup_warning
from robolaser.calibration.initialization import find_start, no_finite_residuals
from robolaser.calibration.misread_joints import misread_joints
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import Calibration, rms
from robolaser.data.dataset import Dataset
from robolaser.estimation.fisher_information import information
from robolaser.estimation.folds import assign_folds, held_out
from robolaser.estimation.identifiability import standard_errors, unidentifiable
from robolaser.estimation.problem import Problem
from robolaser.estimation.robust_reweighting import fit, outlier_warnings
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.model.noise import sizes_of


@contextmanager
def _one_thread() -> Iterator[None]:
    """Linear algebra on one thread.

    Matrices here are tall and thin: a second thread gains nothing on an idle machine, and on a busy one, where it has
    to wait, it made a calibration take ten times as long.
    """
    with threadpool_limits(limits=1, user_api="blas"):
        yield


@_one_thread()
def calibrate(
    dataset: Dataset,
    plan: Plan | None = None,
    *,
    state: Path | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Calibration:
    """Find the parameters of a data set's sensor, and of effects added to the model.

    Args:
        dataset: The measurements, with the nominal values.
        plan: The options; the defaults when absent.
        state: A folder for checkpoints of the search.
        resume: Continue from the checkpoint in `state`.
        progress: Called with the current step and its finished share.

    Raises:
        EstimationError, DataError: The data do not suffice for a calibration.
        EffectError, UsageError: There is no effect, location, algorithm or loss of that name.

    Examples:
        >>> found = robolaser.calibrate(dataset, robolaser.Plan(effects=("laser_roll",)))
        >>> found.rms_m < 0.001
        True
    """
    began = time.perf_counter()
    plan = plan or Plan()
    tell = progress or (lambda what, share: None)
    model = Model(dataset, candidate_effects(plan.effects, dataset))
    problem = Problem.of(model)
    check_target(model)
    check_poses(problem)
    check_orientations(model)

    start = find_start(model, plan, state=state, resume=resume, progress=tell)
    x, evaluations = start.x, start.evaluations
    if plan.polish:
        tell("fitting", 0.5)
        problem, x, more = fit(model, x, weights=plan.weights, loss=plan.loss)
        evaluations += more
    residuals = model.residuals(x[None])[0]
    if not np.isfinite(residuals).all():
        raise no_finite_residuals()

    tell("holding poses out", 0.5)
    folds = assign_folds(model, plan.seed)
    unseen = None if folds is None else held_out(problem, x, folds)
    sigmas = sizes_of(model, x, problem.inliers(x)).sigmas
    known = information(problem, x, sigmas)
    parameters, on_bound = model.parameters, problem.on_bound(x)
    stated = np.array([item.fixed for item in parameters.items])
    return Calibration(
        model=model,
        algorithm=start.algorithm,
        weights=plan.weights,
        loss=plan.loss,
        seed=plan.seed,
        x=x,
        std=standard_errors(known, fixed=problem.fixed, bounded=np.where(on_bound, problem.scale, 0.0)),
        on_bound=on_bound,
        unidentifiable=tuple(unidentifiable(known, parameters.names, parameters.width, stated=stated)),
        residuals=residuals,
        held_out=None if unseen is None else model.in_metres(x, unseen.errors),
        held_out_rows=None if unseen is None else unseen.errors,
        noise=sigmas,
        history=start.history,
        evaluations=evaluations + (0 if unseen is None else unseen.evaluations),
        seconds=time.perf_counter() - began,
        warnings=(
            *_setup_warnings(model, x, residuals, on_bound),
            *dataset.warnings,
            *start.warnings,
            *outlier_warnings(problem, x),
            *_bound_warnings(model, on_bound),
            *(folds.warnings if folds else (TOO_FEW_POSES,)),
        ),
    )


TOO_FEW_POSES = "Too few poses to hold any out: the error on new poses is not known."


def _setup_warnings(model: Model, x: Array, residuals: Array, on_bound: Bools) -> list[str]:
    rms_m = rms(model.in_metres(x, residuals))
    return [warning for warning in (misread_joints(model, rms_m), setup_warning(model, on_bound, rms_m)) if warning]


def _bound_warnings(model: Model, on_bound: Bools) -> list[str]:
    ended = [name for name, at in zip(model.parameters.names, on_bound, strict=True) if at]
    return [f"{name} ended on one of its bounds: widen them, or check the model." for name in ended]
