"""Faults of chance that are large enough to be seen, and how well they are."""

from dataclasses import replace

import numpy as np

from robolaser.trials.building import BlankTrial
from robolaser.trials.detectability import DETECTABLE, Detectability
from robolaser.trials.reading import exact
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models import FAULT_MODELS, OUTLIERS

UNDETECTABLE = 0.08  # of the effects may stay below what can be seen
TRIES = 6
OVERSIZED = 1.5e5  # the squared misfit above which an effect is made smaller: nobody needs help with it
CLEARLY = 2.0  # times detectable, at most, to which a faint effect is grown


def sized_fault(
    built: BlankTrial, name: str, places: tuple[str, ...], rng: np.random.Generator, *, least_misfit: float = DETECTABLE
) -> tuple[FaultModel, Detectability]:
    """A fault of chance, nearly always large enough to be seen.

    Args:
        built: The cell.
        name: One of `FAULT_MODELS`.
        places: Where it may sit.
        rng: Where chance comes from.
        least_misfit: Squared whitened misfit that it should leave.
    """
    fault_model, run = FAULT_MODELS[name], built.cell.run
    least, most = fault_model.sizes
    faint = least_misfit <= DETECTABLE and rng.random() < UNDETECTABLE
    for _ in range(TRIES):
        size = float(np.exp(rng.uniform(np.log(least), np.log(most))))
        fault = fault_model.sample(str(rng.choice(places)), size, run, rng)
        detectability = _seen_by(built, fault, rng)
        misfit = detectability.misfit
        if name == OUTLIERS or (faint and misfit < DETECTABLE) or least_misfit < misfit < OVERSIZED:
            break
        small = misfit < least_misfit
        goal = least_misfit * rng.uniform(1.1, CLEARLY) if small else OVERSIZED * rng.uniform(0.1, 1.0)
        fitting = abs(fault.size) * np.sqrt(goal / max(misfit, 1e-3))
        fault = replace(fault, size=float(np.copysign(min(most, fitting), fault.size)))
        detectability = _seen_by(built, fault, rng)
        if detectability.misfit > least_misfit:
            break
    return fault, detectability


def detectability_of(built: BlankTrial, *faults: FaultModel) -> Detectability:
    """How well faults are seen through the cell's noise; an image that is off counts as an error of its rows' mean."""
    most = int(np.bincount(built.cell.pose).max())
    return Detectability(exact(built, faults), built.cell.truth, _sigmas(built, shared=float(most)))


def noise_floor_m(built: BlankTrial) -> float:
    """Root-mean-square 3-D error that all noise makes, repeats averaged."""
    return Detectability(exact(built, ()), built.cell.truth, _sigmas(built, shared=1.0)).floor_m


def _sigmas(built: BlankTrial, *, shared: float) -> dict[str, float]:
    noise, scatter = built.noise, built.scatter
    pixel = np.hypot(noise.pixel_px or 0.0, np.sqrt(shared) * built.image_px) / np.sqrt(built.repeats)
    return {
        "pixel": float(pixel),
        "target": noise.target_m or 0.0,
        "point": noise.point_m or 0.0,
        "joint": 0.0 if scatter is None else scatter.sigma(built.cell.run),
    }


def _seen_by(built: BlankTrial, fault: FaultModel, rng: np.random.Generator) -> Detectability:
    if fault.effect != OUTLIERS:
        return detectability_of(built, fault)
    plain = detectability_of(built)
    points = plain.dataset.points
    pixel = fault.shots(points["pixel"], np.arange(len(points)), rng)
    return replace(plain, dataset=replace(plain.dataset, points=replace(points, pixel=pixel)))
