"""Parameters from data: a global search, a polish, and what can be said of the result."""

import hashlib
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import final

import numpy as np
from threadpoolctl import threadpool_limits

from robolaser.algorithms.gauss_newton import Polished
from robolaser.algorithms.names import POLISH_ONLY, SCREENING, algorithm_named
from robolaser.arrays import Array, Bools
from robolaser.box import Box, Residuals
from robolaser.calibration import Calibration
from robolaser.dataset import Dataset
from robolaser.effects import suspects
from robolaser.errors import NothingFound
from robolaser.held_out import held_out
from robolaser.jacobian import jacobian
from robolaser.noise import NoiseModel, noise_of
from robolaser.optimum import AGREEING, SAME, Optimum, optimum
from robolaser.readiness import check_poses, check_target
from robolaser.reduction import Reduction
from robolaser.scanner import Model
from robolaser.search import Found, Progress, search
from robolaser.shapes import shaped, with_shapes
from robolaser.uncertainty import standard_errors, unidentifiable

GENERATIONS = 500  # then the polish of every member of the last generation ends in the same optimum
SEARCH_POINTS = 400  # a thinned set ranks candidates as the whole does
UNMOVED_M = 1e-10  # a parameter whose whole range moves points by less only moves the last digits: a step's moment does
REWEIGHTINGS = 3  # the weights depend on the estimate; a fourth round changes nothing any more


@final
@dataclass(frozen=True)
class Plan:
    """How to calibrate.

    Attributes:
        algorithm: Name of the global search; by default `screening` for a stripe scanner and none (`gauss-newton`)
            for trackers and sockets, whose parameters start from a closed form.
        polish: Whether Gauss-Newton steps follow the search.
        weights: "plain" minimises J as it stands; "noise" weighs residuals by the covariance of their noise.
        effects: `EFFECT[:WHERE]` each.
        seed: Of the search.
        generations: Of a search that has any.
    """

    algorithm: str | None = None
    polish: bool = True
    weights: str = "plain"
    effects: tuple[str, ...] = ()
    seed: int = 1
    generations: int = GENERATIONS


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
        EffectUnknown, PlaceUnknown, EffectSenseless, AlgorithmUnknown: Something asked for is not there.
    """
    began = time.perf_counter()
    plan = plan or Plan()
    tell = progress or (lambda what, share: None)
    model = Model(dataset, suspects(plan.effects, dataset))
    box = Box.of(model)
    check_target(model)
    check_poses(model, box)

    algorithm = plan.algorithm or (SCREENING if model.sensor.own else POLISH_ONLY)
    if algorithm not in (SCREENING, POLISH_ONLY):
        algorithm_named(algorithm)
    doubts = []
    if algorithm != POLISH_ONLY and not len(Reduction(model).parameters):
        doubts.append(f"{algorithm} had nothing to search for: every parameter follows from the data in closed form.")
        algorithm = POLISH_ONLY
    thin = Model(dataset.thinned(SEARCH_POINTS), model.suspects)
    found: Found | None = None
    if algorithm == SCREENING:
        x, evaluations, screening_doubts = _screened(thin, plan.seed, tell)
        doubts += screening_doubts
    else:
        starts = model.parameters.nominal[None]
        if algorithm != POLISH_ONLY:
            found, starts = _searched(thin, algorithm, plan, state=state, resume=resume, progress=tell)
        x, evaluations = starts[0], found.evaluations if found else 0
        if plan.polish:
            tell("polishing", 0.0)
            best, tried = _polished_in_shape(thin, np.insert(starts, 1, model.parameters.nominal, axis=0), box)
            x, evaluations = best.x, evaluations + tried
    weights: NoiseModel | None = None
    residuals = Residuals(model)
    if plan.polish:
        tell("polishing", 0.5)
        end = box.polish(residuals, x)
        evaluations += end.evaluations
        for _ in range(REWEIGHTINGS if plan.weights == "noise" else 0):
            weights = noise_of(model, end.x).for_weights()
            residuals = Residuals(model, weights)
            end = box.polish(residuals, end.x)
            evaluations += end.evaluations
        x = end.x
    E = model.residuals(x[None])[0]
    if not np.isfinite(E).all():
        raise NothingFound()

    tell("holding poses out", 0.5)
    unseen, tried = held_out(residuals, x, box, seed=plan.seed)
    on_bound = box.on_bound(x)
    J = jacobian(model, x)
    J = np.where(np.abs(J).max(axis=0) * model.parameters.width > UNMOVED_M, J, 0.0)
    noise = noise_of(model, x, J)
    std = standard_errors(J, noise, held=box.held, weights=weights, bounded=np.where(on_bound, box.scale, 0.0))
    parameters = model.parameters
    return Calibration(
        model=model,
        algorithm=algorithm,
        weights=plan.weights,
        seed=plan.seed,
        x=x,
        std=std,
        on_bound=on_bound,
        unidentifiable=tuple(unidentifiable(J, parameters.names, parameters.width, noise, weights=weights)),
        residuals=E,
        held_out=unseen,
        noise=noise.sigmas,
        history=found.history if found else None,
        evaluations=evaluations + tried,
        seconds=time.perf_counter() - began,
        warnings=(*dataset.warnings, *doubts, *_doubts(model, on_bound, unseen)),
    )


def _screened(thin: Model, seed: int, tell: Progress) -> tuple[Array, int, list[str]]:
    """The global optimum of a thinned set: first without effects, then with them, last with those that have shapes.

    Returns:
        The parameters, the candidates evaluated, and doubts.
    """

    def found(model: Model, starts: Array | None) -> Optimum:
        return optimum(model, seed=seed, starts=starts, progress=lambda share: tell("searching", share))

    sought = shaped(thin)
    plain = thin.with_suspects(tuple(one for one in thin.suspects if one not in sought))
    best = found(thin.with_suspects(()), None)
    evaluations = best.evaluations
    if plain.suspects:
        best = found(plain, _extended(best.x, plain)[None])
        evaluations += best.evaluations
    if not np.isfinite(best.cost):
        raise NothingFound()
    doubts = []
    if best.agreeing < AGREEING:
        doubts.append(
            f"Only {best.agreeing} of {best.descents} descents ended at the lowest J that was found: there may be a "
            "lower one. Narrower bounds would help, or other poses."
        )
    x = best.x
    if sought:
        values = dict(zip(plain.parameters.names, x, strict=True)) | with_shapes(plain, x, sought)
        x = np.array([values[name] for name in thin.parameters.names])
    return x, evaluations, doubts


def _extended(x: Array, model: Model) -> Array:
    """Parameters of the bare model (d,) as those of a model with effects, which are at their nominal values."""
    return np.append(x, model.parameters.nominal[len(x) :])


def _searched(
    thin: Model, algorithm: str, plan: Plan, *, state: Path | None, resume: bool, progress: Progress
) -> tuple[Found, Array]:
    """Search globally; candidates come back as those of the whole model, best first."""
    from robolaser.problems import ReducedCalibration  # noqa: PLC0415 - pymoo takes a second to import

    problem = ReducedCalibration(thin)
    found = search(
        problem,
        algorithm_named(algorithm),
        generations=plan.generations,
        seed=plan.seed,
        state=state,
        resume=resume,
        fingerprint=_fingerprint(thin.dataset, plan),
        progress=progress,
    )
    return found, problem.completed(found.candidates)


def _polished_in_shape(model: Model, starts: Array, box: Box) -> tuple[Polished, int]:
    """Polish members; where effects have shapes, those that do best where the model without these effects ends.

    Each member has shapes of its own, and ends in a valley of its own: they would never agree. So members are polished
    without the effects, and with them only the first, beside the shapes that were chosen.

    Returns:
        The best, and the candidates evaluated.
    """
    sought = shaped(model)
    if not sought:
        return polish_members(Residuals(model), starts, box)
    plain = model.with_suspects(tuple(one for one in model.suspects if one not in sought))
    columns = model.parameters.columns(plain.parameters.names)
    without, evaluations = polish_members(Residuals(plain), starts[:, columns], Box.of(plain))
    values = dict(zip(plain.parameters.names, without.x, strict=True)) | with_shapes(plain, without.x, sought)
    chosen = np.array([values[name] for name in model.parameters.names])
    ends = [box.polish(Residuals(model), start) for start in (chosen, model.with_gauge_held(starts[0]))]
    return min(ends, key=lambda end: end.cost), evaluations + sum(end.evaluations for end in ends)


def polish_members(residuals: Residuals, starts: Array, box: Box) -> tuple[Polished, int]:
    """Polish members, best first, until enough of them agree on the lowest optimum, or all have been tried.

    Args:
        residuals: What to polish on.
        starts: (k, d); some may lie at poles.
        box: Where the polish may go.

    Returns:
        The best, and the candidates evaluated.

    Raises:
        NothingFound: All starts lie at poles.
    """
    tried, evaluations = [], 0
    for start in starts:
        tried.append(box.polish(residuals, residuals.model.with_gauge_held(start)))
        evaluations += tried[-1].evaluations
        lowest = min(end.cost for end in tried)
        if sum(end.cost <= lowest * (1 + SAME) + np.finfo(float).tiny for end in tried) >= AGREEING:
            break
    best = min(tried, key=lambda end: end.cost)
    if not np.isfinite(best.cost):
        raise NothingFound()
    return best, evaluations


def _doubts(model: Model, on_bound: Bools, unseen: Array | None) -> list[str]:
    ended = [name for name, at in zip(model.parameters.names, on_bound, strict=True) if at]
    doubts = [f"{name} ended on one of its bounds: widen them, or doubt the model." for name in ended]
    if unseen is None:
        doubts.append("Too few poses to hold any out: the error on new poses is not known.")
    return doubts


def _fingerprint(dataset: Dataset, plan: Plan) -> str:
    """Says what a search is about: the data, their nominal values and bounds, and the plan."""
    points, poses = dataset.points, dataset.poses
    arrays = (points.pose, points.pixel, points.xyz, poses.q, poses.T_base_flange)
    digest = hashlib.sha256(repr((asdict(plan), sorted(dataset.parameters.items()))).encode())
    for array in arrays:
        digest.update(b"-" if array is None else array.tobytes())
    return digest.hexdigest()
