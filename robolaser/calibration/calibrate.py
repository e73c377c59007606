"""Parameters from data: a global search, a polish, and what can be said of the result."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from robolaser.arrays import Array, Bools
from robolaser.calibration.checks import check_poses, check_target
from robolaser.calibration.initialization import start_of
from robolaser.calibration.options import Plan
from robolaser.calibration.pymoo_search import Progress
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset
from robolaser.errors import NothingFound
from robolaser.estimation.cross_validation import held_out
from robolaser.estimation.fisher_information import information
from robolaser.estimation.identifiability import standard_errors, unidentifiable
from robolaser.estimation.problem import Box, Residuals
from robolaser.estimation.robust_reweighting import gross, polished
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.model.noise import sizes_of


@contextmanager
def _one_thread() -> Iterator[None]:
    """Linear algebra on one thread.

    Matrices here are tall and thin: a second thread gains nothing on an idle machine, and on a busy one, where it waits
    for its turn, it made a calibration ten times as long.
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
        dataset: What was measured.
        plan: How.
        state: A folder for checkpoints of the search.
        resume: Go on from the checkpoint there.
        progress: Is told what is going on.

    Raises:
        TooFewPoses, TargetUnseen, NothingFound: The data cannot be calibrated from.
        EffectError, UsageError, AlgorithmUnknown, LossUnknown: Something asked for is not there.
    """
    began = time.perf_counter()
    plan = plan or Plan()
    tell = progress or (lambda what, share: None)
    model = Model(dataset, candidate_effects(plan.effects, dataset))
    box = Box.of(model)
    check_target(model)
    check_poses(model, box)

    start = start_of(model, plan, state=state, resume=resume, progress=tell)
    x, evaluations = start.x, start.evaluations
    residuals = Residuals(model)
    if plan.polish:
        tell("polishing", 0.5)
        residuals, x, tried = polished(model, box, x, weights=plan.weights, loss=plan.loss)
        evaluations += tried
    E = model.residuals(x[None])[0]
    if not np.isfinite(E).all():
        raise NothingFound()

    tell("holding poses out", 0.5)
    unseen, tried = held_out(residuals, x, box, seed=plan.seed)
    on_bound = box.on_bound(x)
    sigmas = sizes_of(model, x, residuals.trusted(x)).sigmas
    known = information(residuals, x, sigmas)
    parameters = model.parameters
    return Calibration(
        model=model,
        algorithm=start.algorithm,
        weights=plan.weights,
        loss=plan.loss,
        seed=plan.seed,
        x=x,
        std=standard_errors(known, held=box.held, bounded=np.where(on_bound, box.scale, 0.0)),
        on_bound=on_bound,
        unidentifiable=tuple(unidentifiable(known, parameters.names, parameters.width)),
        residuals=E,
        held_out=unseen,
        noise=sigmas,
        history=start.history,
        evaluations=evaluations + tried,
        seconds=time.perf_counter() - began,
        warnings=(*dataset.warnings, *start.doubts, *gross(residuals, x), *_doubts(model, on_bound, unseen)),
    )


def _doubts(model: Model, on_bound: Bools, unseen: Array | None) -> list[str]:
    ended = [name for name, at in zip(model.parameters.names, on_bound, strict=True) if at]
    doubts = [f"{name} ended on one of its bounds: widen them, or doubt the model." for name in ended]
    if unseen is None:
        doubts.append("Too few poses to hold any out: the error on new poses is not known.")
    return doubts
