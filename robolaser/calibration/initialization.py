"""The start of the fit: near the global optimum, found on a subsample."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np

from robolaser.algorithms.registry import POLISH_ONLY, SCREENING, algorithm_named
from robolaser.arrays import Array, Progress
from robolaser.calibration.misread import misread
from robolaser.calibration.plan import Plan
from robolaser.calibration.pymoo_search import History, search
from robolaser.data.dataset_file import FULL_TURN
from robolaser.data.joining import fingerprint
from robolaser.errors import EstimationError
from robolaser.estimation.multistart import AGREEING, SAME, Optimum, check_bounds, multistart, subsampled
from robolaser.estimation.nonlinear_parameters import initialize_effects, with_nonlinear_grid
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.geometry.rigid_motion import inverse, log_so3
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import SIX, motion
from robolaser.parameters import as_batch

FAR = 0.1
"""Of the bounds' width: the error of a closed form is smaller, so a value farther beyond a bound is really outside."""
AT_ONCE = 4  # members of a population that descend together


def no_finite_residuals() -> EstimationError:
    """The error raised where no candidate has finite residuals."""
    return EstimationError(
        "No set of parameters within the bounds puts the points at finite places. "
        "Check the bounds in [parameters], the sensor's mount or stripe_axis, and the units."
    )


@final
@dataclass(frozen=True, eq=False)
class Start:
    """The end of the search, where the fit starts."""

    algorithm: str  # name of the search
    x: Array  # the parameters, (d,)
    evaluations: int  # candidates evaluated
    warnings: tuple[str, ...] = ()  # what the user should know
    history: History | None = None  # the course of the search, where it has generations


def find_start(
    model: Model, plan: Plan, *, state: Path | None = None, resume: bool = False, progress: Progress | None = None
) -> Start:
    """Run the search that the plan names; arguments as for `calibrate`.

    Raises:
        EstimationError: No candidate has finite residuals; it names joints that seem to be misread.
        UsageError: There is no algorithm of that name.
    """
    try:
        return _start(model, plan, state=state, resume=resume, progress=progress or (lambda what, share: None))
    except EstimationError as error:
        found = misread(model, np.inf)
        if found is None:
            raise
        raise EstimationError(f"{found.sentence} As it is: {error}") from None


def _start(model: Model, plan: Plan, *, state: Path | None, resume: bool, progress: Progress) -> Start:
    unbounded = model.sensor_parameters.unbounded(model.blocks.free)
    algorithm = plan.algorithm or (SCREENING if model.blocks.free and not unbounded else POLISH_ONLY)
    if algorithm == POLISH_ONLY:
        return _downhill(model, plan)
    if algorithm != SCREENING:
        algorithm_named(algorithm)
    check_bounds(model, f"--algorithm {algorithm}")
    is_fixed = bool(Problem.of(model).fixed.all())
    if algorithm == SCREENING and (is_fixed or model.blocks.free or model.effects):
        return _multistart(model, plan.seed, progress)
    if is_fixed or not (model.blocks.free or model.effects):
        why = "is fixed" if is_fixed else "follows from the data in closed form"
        warning = f"{algorithm} had nothing to search for: every parameter {why}."
        return replace(_downhill(model, plan), warnings=(warning,))
    thin = subsampled(model)
    members, history = _searched(thin, algorithm, plan, state=state, resume=resume, progress=progress)
    x, evaluations = members[0], int(history.evaluations[-1])
    if plan.polish:
        progress("fitting", 0.0)
        x, more = _descended(thin, np.insert(members, 1, model.parameters.nominal, axis=0))
        evaluations += more
    return Start(algorithm, x, evaluations, history=history)


def _downhill(model: Model, plan: Plan) -> Start:
    """The better optimum of descents from the nominal values and, if it differs, from the closed form."""
    nominal = model.parameters.nominal
    if not plan.polish:
        return Start(POLISH_ONLY, nominal, 0)
    of_data, warnings = start_of_data(model)
    return Start(POLISH_ONLY, *_descended(subsampled(model), np.vstack([nominal[None], *of_data])), warnings)


def _multistart(model: Model, seed: int, progress: Progress) -> Start:
    """The global optimum: first without effects, then with them, last with those that have nonlinear parameters."""

    def optimum(part: Model, starts: Array | None) -> Optimum:
        return multistart(part, seed=seed, starts=starts, progress=lambda share, *_: progress("searching", share))

    nonlinear = with_nonlinear_grid(model)
    plain = _without(model, nonlinear)
    best = optimum(model.with_effects(()), None)
    evaluations = best.evaluations
    if plain.effects:
        extended = np.append(best.x, plain.parameters.nominal[len(best.x) :])
        best = optimum(plain, np.stack([extended, plain.parameters.nominal]))
        evaluations += best.evaluations
    if not np.isfinite(best.cost):
        raise no_finite_residuals()
    warnings = []
    if best.agreeing < AGREEING:
        warnings.append(
            f"Only {best.agreeing} of {best.descents} descents ended at the lowest J that was found: there may be a "
            "lower one. Narrower bounds would help, or other poses."
        )
    x = _with_effects_chosen(subsampled(model), plain.effects, best.x) if nonlinear else best.x
    return Start(SCREENING, x, evaluations, tuple(warnings))


def _without(model: Model, gone: Sequence[CandidateEffect]) -> Model:
    """The model without some of its effects."""
    return model.with_effects(tuple(one for one in model.effects if one not in gone))


def _with_effects_chosen(model: Model, effects: tuple[CandidateEffect, ...], x: Array) -> Array:
    """The optimum x (d,) of the model with some of its effects, extended by start values of the nonlinear ones."""
    plain = model.with_effects(effects)
    values = dict(zip(plain.parameters.names, x, strict=True))
    values |= initialize_effects(plain, x, with_nonlinear_grid(model))
    return np.array([values[name] for name in model.parameters.names])


def _searched(
    thin: Model, algorithm: str, plan: Plan, *, state: Path | None, resume: bool, progress: Progress
) -> tuple[Array, History]:
    """Search globally; returns candidates of the whole model, best first."""
    from robolaser.algorithms.seeding import seeded  # noqa: PLC0415 - pymoo takes a second to import
    from robolaser.problems import ReducedCalibration  # noqa: PLC0415

    problem = ReducedCalibration(thin)
    with seeded(plan.seed):
        candidates, history = search(
            problem,
            algorithm_named(algorithm),
            generations=plan.generations,
            seed=plan.seed,
            state=state,
            resume=resume,
            fingerprint=fingerprint(thin.dataset, plan),
            progress=progress,
        )
    return problem.completed(candidates), history


def _descended(model: Model, starts: Array) -> tuple[Array, int]:
    """The best optimum (d,) of descents from some members, and the candidates evaluated.

    With nonlinear parameters of effects, each member would end in a different valley: they would never agree. So
    members descend without these effects, and only the first with them, from chosen values.
    """
    nonlinear = with_nonlinear_grid(model)
    if not nonlinear:
        return descend_until_agreed(Problem.of(model), starts)
    plain = _without(model, nonlinear)
    columns = model.parameters.columns(plain.parameters.names)
    x, evaluations = descend_until_agreed(Problem.of(plain), starts[:, columns])
    both = np.stack([_with_effects_chosen(model, plain.effects, x), model.fix_gauge(starts[0])])
    ends = solve(Problem.of(model), both)
    return ends.x[int(np.argmin(ends.cost))], evaluations + ends.evaluations


def descend_until_agreed(problem: Problem, starts: Array) -> tuple[Array, int]:
    """Descend from members (k, d), best first, until enough agree on the lowest optimum, or all have been tried.

    Returns:
        The best optimum (d,), and the candidates evaluated.

    Raises:
        EstimationError: No start has finite residuals.
    """
    starts = np.array([problem.model.fix_gauge(start) for start in starts])
    x, costs, evaluations = np.empty((0, starts.shape[1])), np.empty(0), 0
    for first in range(0, len(starts), AT_ONCE):
        ends = solve(problem, starts[first : first + AT_ONCE])
        x, costs = np.concatenate([x, ends.x]), np.concatenate([costs, ends.cost])
        evaluations += ends.evaluations
        if np.isfinite(costs.min()) and (costs <= costs.min() * (1 + SAME) + np.finfo(float).tiny).sum() >= AGREEING:
            break
    if not np.isfinite(costs.min()):
        raise no_finite_residuals()
    return x[int(np.argmin(costs))], evaluations


def start_of_data(model: Model) -> tuple[Sequence[Array], tuple[str, ...]]:
    """A start besides the nominal values, and warnings if the data set's bounds exclude it.

    Returns:
        The closed-form values, (d,), within the bounds, if the data set gives others; and a sentence for each
        placement outside them.
    """
    items, derived = model.parameters.items, model.blocks.derived
    stated = {item.name: item for item in items if item.name in derived and item.given and not item.fixed}
    nominal = {item.name: np.array([item.nominal]) for item in items}
    if not stated:
        return [], ()
    try:
        closed = model.completed({name: value for name, value in nominal.items() if name not in derived})
    except EstimationError:
        return [], ()
    found = {name: float(closed[name][0] if name in closed else value[0]) for name, value in nominal.items()}
    for place in {name.rpartition(".")[0] for name in stated}:
        found |= _nearest_angles(found, {name: item.nominal for name, item in stated.items()}, place)
    beyond = {
        name.rpartition(".")[0]
        for name, item in stated.items()
        if "." in name and max(item.lower - found[name], found[name] - item.upper) > FAR * (item.upper - item.lower)
    }
    sentences = tuple(_sentence(place, nominal, found) for place in sorted(beyond))
    x = np.array([np.clip(found[item.name], item.lower, item.upper) for item in items])
    return [x], sentences


def _nearest_angles(found: Mapping[str, float], given: Mapping[str, float], frame: str) -> dict[str, float]:
    """The three angles of a rotation; of all equivalent ones, the nearest to the given angles."""
    names = [f"{frame}.{part}" for part in SIX[3:]]
    if any(name not in found or name not in given for name in names):
        return {}
    w, phi, psi = (found[name] for name in names)
    near = np.array([given[name] for name in names])
    same = np.array([[w, phi, psi], [w + np.pi, np.pi - phi, psi + np.pi]])
    same += FULL_TURN * np.round((near - same) / FULL_TURN)
    nearest = same[int(np.argmin(np.abs(same - near).sum(axis=1)))]
    return dict(zip(names, nearest.tolist(), strict=True))


def _sentence(place: str, nominal: Mapping[str, Array], found: Mapping[str, float]) -> str:
    there = as_batch(found)
    parts = [f"{place}.{part}" for part in SIX if f"{place}.{part}" in found]
    if len(parts) == len(SIX):
        apart = inverse(motion(nominal, place)) @ motion(there, place)
        turn, shift = float(np.linalg.norm(log_so3(apart[0, :3, :3]))), float(np.linalg.norm(apart[0, :3, 3]))
        far = f"{np.degrees(turn):.0f}° and {1e3 * shift:.0f} mm"
    else:
        shift = float(np.linalg.norm([found[name] - nominal[name][0] for name in parts]))
        far = f"{1e3 * shift:.0f} mm"
    return (
        f"The data put {place} {far} from its nominal value, outside the bounds that [parameters] states."
        f" Delete {place}.* there, or correct it."
    )
