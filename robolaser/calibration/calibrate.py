"""Parameters from data: a global search, a least-squares fit, and the uncertainty of the result."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from robolaser.arrays import Array, Bools, Progress
from robolaser.calibration.checks import check_orientations, check_poses, check_target, travel_warnings
from robolaser.calibration.contradicted_distance import ContradictedDistance
from robolaser.calibration.exchanged_poses import exchanged_warning
from robolaser.calibration.initialization import find_start, no_finite_residuals
from robolaser.calibration.misread import misread
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset
from robolaser.estimation.fisher_information import information
from robolaser.estimation.folds import assign_folds, held_out
from robolaser.estimation.identifiability import standard_errors, unidentifiable
from robolaser.estimation.noise_estimate import noise_of
from robolaser.estimation.noise_weighted_fit import NoiseWeightedFit, fit_by_noise
from robolaser.estimation.plain_fit import fit
from robolaser.estimation.problem import Problem
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model


def calibrate(
    dataset: Dataset,
    plan: Plan | None = None,
    *,
    state: Path | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Calibration:
    """As `robolaser.calibrate`; the search leaves checkpoints in the folder `state`, and may resume from one there."""
    began = time.perf_counter()
    plan = plan or Plan()
    # matrices are tall and thin: a second thread gains nothing on an idle machine, and made a calibration ten times
    # slower on a busy one
    with threadpool_limits(limits=1, user_api="blas"):
        model = Model(dataset, candidate_effects(plan.effects, dataset))
        check_target(model)
        check_poses(Problem.of(model))
        check_orientations(model)
        found = calibrated(model, plan, state=state, resume=resume, progress=progress)
        other = misread(model, found.rms_m)
        suspicions = (other and other.sentence, exchanged_warning(found), found.setup_warning)
        doubts = [warning for warning in suspicions if warning]
        return replace(found, warnings=(*doubts, *found.warnings), seconds=time.perf_counter() - began)


def calibrated(
    model: Model, plan: Plan, *, state: Path | None = None, resume: bool = False, progress: Progress | None = None
) -> Calibration:
    """The calibration of a model of checked data, without warnings about the setup; arguments as for `calibrate`."""
    announce = progress or (lambda what, share: None)
    start = find_start(model, plan, state=state, resume=resume, progress=announce)
    problem, x, evaluations, weighted = Problem.of(model), start.x, start.evaluations, None
    if plan.polish:
        announce("fitting", 0.5)
        if plan.weights == "noise":
            weighted = fit_by_noise(model, x, seed=plan.seed)
            problem, x, more = weighted.problem, weighted.x, weighted.evaluations
        else:
            problem, x, more = fit(model, x)
        evaluations += more
    residuals = model.residuals(x[None])[0]
    if not np.isfinite(residuals).all():
        raise no_finite_residuals()

    announce("holding poses out", 0.5)
    folds = assign_folds(problem.model, plan.seed)
    unseen = folds and (weighted.held_out(folds) if weighted else held_out(problem, x, folds))
    sigmas = noise_of(model, x, None if weighted is None else ~weighted.outliers).sigmas
    known = information(problem, x, sigmas, None if weighted is None else weighted.data.shots)
    parameters, on_bound = model.parameters, problem.on_bound(x)
    stated = np.array([item.fixed for item in parameters.items])
    groups = tuple(unidentifiable(known, parameters.names, parameters.width, stated=stated))
    return Calibration(
        model=model,
        algorithm=start.algorithm,
        weights=plan.weights,
        seed=plan.seed,
        x=x,
        std=standard_errors(known, fixed=problem.fixed, bounded=np.where(on_bound, problem.scale, 0.0)),
        on_bound=on_bound,
        unidentifiable=groups,
        residuals=residuals,
        held_out=None if unseen is None else problem.model.in_metres(x, unseen.errors),
        unseen=unseen,
        noise=sigmas,
        history=start.history,
        evaluations=evaluations + (0 if unseen is None else unseen.evaluations),
        warnings=(
            *model.dataset.warnings,
            *start.warnings,
            *(_unused_warnings(weighted) if weighted else ()),
            *bound_warnings(model, on_bound),
            *_distance_warnings(model, x),
            *travel_warnings(model, dict.fromkeys(name for group in groups for name in group.parameters)),
            *(folds.warnings if folds else (TOO_FEW_POSES,)),
        ),
        fitted=problem.model,
        weighted=weighted,
    )


def _unused_warnings(weighted: NoiseWeightedFit) -> list[str]:
    """Warnings on the rows that the fit does not use."""
    gross, poses = int(weighted.outliers.sum()), weighted.data.raw.points.pose
    used, every = len(np.unique(weighted.data.dataset.points.pose)), len(np.unique(poses))
    warnings = []
    if gross:
        warnings.append(
            f"{gross} of {len(poses)} points are gross errors: they are excluded from the fit and from the error on new"
            " poses, but count in J and in the error on fitted poses."
        )
    if used < every:
        warnings.append(
            f"{used} of {every} poses are used: with rows weighted by their noise, more would change the fit little."
        )
    return warnings


def _distance_warnings(model: Model, x: Array) -> list[str]:
    off = ContradictedDistance.of(model, x)
    return [f"{off.clause}: measure it again, or look for effects with `robolaser diagnose`."] if off else []


TOO_FEW_POSES = "Too few poses to hold any out: the error on new poses is not known."


def bound_warnings(model: Model, on_bound: Bools) -> list[str]:
    """A sentence on each parameter that ended on a bound (d,)."""
    ended = [name for name, at in zip(model.parameters.names, on_bound, strict=True) if at]
    fixed = dict.fromkeys(model.effect_parameters.names, ", which are the effect's own: it has no standard error")
    return [
        f"{name} ended on one of its bounds{fixed.get(name, ': widen them, or check the model')}." for name in ended
    ]
