"""Where the last polish starts: near the global optimum, found on a thinned set."""

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import final

import numpy as np

from robolaser.algorithms.registry import POLISH_ONLY, SCREENING, algorithm_named
from robolaser.arrays import Array
from robolaser.calibration.options import Plan
from robolaser.calibration.pymoo_search import Found, History, Progress, search
from robolaser.data.dataset import Dataset
from robolaser.errors import NothingFound
from robolaser.estimation.gauss_newton import Polished
from robolaser.estimation.multistart import AGREEING, SAME, Optimum, optimum, thinned
from robolaser.estimation.nonlinear_parameters import shaped, with_shapes
from robolaser.estimation.problem import Box, Residuals
from robolaser.estimation.reduction import Reduction
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model


@final
@dataclass(frozen=True, eq=False)
class Start:
    """Where a search ended and the last polish starts.

    Attributes:
        algorithm: Name of the search.
        x: The parameters, (d,).
        evaluations: Candidates evaluated.
        doubts: What the user should know.
        history: The course of the search, where it has generations.
    """

    algorithm: str
    x: Array
    evaluations: int
    doubts: tuple[str, ...] = ()
    history: History | None = None


def start_of(model: Model, plan: Plan, *, state: Path | None, resume: bool, progress: Progress) -> Start:
    """Search as planned.

    Args:
        model: The whole model.
        plan: Names the search.
        state: A folder for checkpoints of the search.
        resume: Go on from the checkpoint there.
        progress: Is told what is going on.

    Raises:
        NothingFound: All candidates lie at poles.
        AlgorithmUnknown: There is none of that name.
    """
    algorithm = plan.algorithm or (SCREENING if model.sensor.free else POLISH_ONLY)
    if algorithm not in (SCREENING, POLISH_ONLY):
        algorithm_named(algorithm)
    thin = thinned(model)
    if algorithm != POLISH_ONLY and not len(Reduction(model).parameters):
        doubt = f"{algorithm} had nothing to search for: every parameter follows from the data in closed form."
        return replace(_straight(thin, plan), doubts=(doubt,))
    if algorithm == POLISH_ONLY:
        return _straight(thin, plan)
    if algorithm == SCREENING:
        return _screened(model, plan.seed, progress)
    found, members = _searched(thin, algorithm, plan, state=state, resume=resume, progress=progress)
    if not plan.polish:
        return Start(algorithm, members[0], found.evaluations, history=found.history)
    progress("polishing", 0.0)
    best, tried = _polished_in_shape(thin, np.insert(members, 1, model.parameters.nominal, axis=0))
    return Start(algorithm, best.x, found.evaluations + tried, history=found.history)


def _straight(thin: Model, plan: Plan) -> Start:
    """From the nominal values downhill."""
    nominal = thin.parameters.nominal
    if not plan.polish:
        return Start(POLISH_ONLY, nominal, 0)
    best, tried = _polished_in_shape(thin, nominal[None])
    return Start(POLISH_ONLY, best.x, tried)


def _screened(model: Model, seed: int, tell: Progress) -> Start:
    """The global optimum: first without effects, then with them, last with those that have shapes."""

    def found(part: Model, starts: Array | None) -> Optimum:
        return optimum(part, seed=seed, starts=starts, progress=lambda so_far: tell("searching", so_far.share))

    sought = shaped(model)
    plain = _without(model, sought)
    best = found(model.with_effects(()), None)
    evaluations = best.evaluations
    if plain.effects:
        best = found(plain, np.stack([_extended(best.x, plain), plain.parameters.nominal]))
        evaluations += best.evaluations
    if not np.isfinite(best.cost):
        raise NothingFound()
    doubts = []
    if best.agreeing < AGREEING:
        doubts.append(
            f"Only {best.agreeing} of {best.descents} descents ended at the lowest J that was found: there may be a "
            "lower one. Narrower bounds would help, or other poses."
        )
    thin = thinned(model)
    x = _in_shape(thin, thin.with_effects(plain.effects), best.x) if sought else best.x
    return Start(SCREENING, x, evaluations, tuple(doubts))


def _without(model: Model, gone: Sequence[CandidateEffect]) -> Model:
    """The model that lacks some of its effects."""
    return model.with_effects(tuple(one for one in model.effects if one not in gone))


def _extended(x: Array, model: Model) -> Array:
    """Parameters of the bare model (d,) as those of a model with effects, which are at their nominal values."""
    return np.append(x, model.parameters.nominal[len(x) :])


def _in_shape(model: Model, plain: Model, x: Array) -> Array:
    """Parameters of a model that lacks the effects with shapes (d,) as those of one that has them, shapes chosen."""
    values = dict(zip(plain.parameters.names, x, strict=True)) | with_shapes(plain, x, shaped(model))
    return np.array([values[name] for name in model.parameters.names])


def _searched(
    thin: Model, algorithm: str, plan: Plan, *, state: Path | None, resume: bool, progress: Progress
) -> tuple[Found, Array]:
    """Search globally; candidates come back as those of the whole model, best first."""
    from robolaser.algorithms.seeding import seeded  # noqa: PLC0415 - pymoo takes a second to import
    from robolaser.problems import ReducedCalibration  # noqa: PLC0415

    problem = ReducedCalibration(thin)
    with seeded(plan.seed):
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


def _polished_in_shape(model: Model, starts: Array) -> tuple[Polished, int]:
    """Polish members; where effects have shapes, those that do best where the model without these effects ends.

    Each member has shapes of its own, and ends in a valley of its own: they would never agree. So members are polished
    without the effects, and with them only the first, beside the shapes that were chosen.

    Returns:
        The best, and the candidates evaluated.
    """
    sought, box = shaped(model), Box.of(model)
    if not sought:
        return polish_members(Residuals(model), starts, box)
    plain = _without(model, sought)
    columns = model.parameters.columns(plain.parameters.names)
    without, evaluations = polish_members(Residuals(plain), starts[:, columns], Box.of(plain))
    chosen = _in_shape(model, plain, without.x)
    ends = [box.polish(Residuals(model), start) for start in (chosen, model.fix_gauge(starts[0]))]
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
        tried.append(box.polish(residuals, residuals.model.fix_gauge(start)))
        evaluations += tried[-1].evaluations
        lowest = min(end.cost for end in tried)
        if sum(end.cost <= lowest * (1 + SAME) + np.finfo(float).tiny for end in tried) >= AGREEING:
            break
    best = min(tried, key=lambda end: end.cost)
    if not np.isfinite(best.cost):
        raise NothingFound()
    return best, evaluations


def _fingerprint(dataset: Dataset, plan: Plan) -> str:
    """Says what a search is about: the data, their nominal values and bounds, and the plan."""
    points, poses = dataset.points, dataset.poses
    arrays = (points.pose, points.pixel, points.xyz, poses.q, poses.T_base_flange)
    digest = hashlib.sha256(repr((asdict(plan), sorted(dataset.parameters.items()))).encode())
    for array in arrays:
        digest.update(b"-" if array is None else array.tobytes())
    return digest.hexdigest()
