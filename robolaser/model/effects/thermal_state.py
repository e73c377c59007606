"""Progress of a warm-up in the course of a run, from 0 towards 1, and in another run."""

from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import NOT_WARM, CarryOver, Effect, Run, nonlinear
from robolaser.model.effects.run import temperature_rise

SHORTEST, LONGEST, USUAL = 0.05, 3.0, 0.3  # time constant over the length of the run
EVEN = 1e-6  # settling, below which a creep is as good as even
SETTLINGS = (0.0, 1.5, 3.5, 8.0)  # of a creep, to try: even with the first, over in a third of the run with the last
TRIED = 6  # time constants; the curves of two neighbours agree to a few per cent


def time_constant() -> Any:
    """Declare it as a nonlinear parameter."""
    return nonlinear(unit="", lower=SHORTEST, upper=LONGEST, nominal=USUAL)


def settling() -> Any:
    """Declare that of a creep as a nonlinear parameter."""
    return nonlinear(unit="", lower=0.0, upper=SETTLINGS[-1], nominal=0.0, tried=SETTLINGS)


def warmed(run: Run, tau: Array) -> Array:
    """Rise of temperature over its largest where it was measured, else 1 - exp(-progress / tau), (c,) -> (c or 1, n).

    Source: Newton's law of cooling, towards a constant temperature.
    """
    return run.rise[None] if run.rise is not None else -np.expm1(-run.progress / tau[:, None])


def time_constants(dataset: Dataset) -> Array:
    """Time constants to try, (g, 1): only one where temperatures were measured, which need none."""
    measured = temperature_rise(dataset.poses) is not None
    return np.array([[USUAL]]) if measured else np.geomspace(SHORTEST, LONGEST, TRIED)[:, None]


def carried_by_temperature(effect: Effect, run: Run) -> CarryOver:
    """A warm-up follows the thermometer of another run; without one it stays as at the end of the first run."""
    by_thermometer = run.course is not None and run.course.by_thermometer
    return CarryOver(effect) if by_thermometer else CarryOver(effect, doubt=NOT_WARM, alternatives=(None,))


def crept(progress: Array, settling: Array) -> Array:
    """Share of a creep that has happened, (n,) and (c,) -> (c, n): 0 at the start of the run and 1 at its end.

    :math:`(1 - e^{-s p}) / (1 - e^{-s})` of the progress p, where s is `settling`: even with 0.
    """
    even = settling[:, None] < EVEN
    rate = np.where(even, 1.0, settling[:, None])
    with np.errstate(over="ignore"):
        curved = np.expm1(-rate * progress) / np.expm1(-rate)
    return np.where(even, progress * (1.0 + settling[:, None] * (1.0 - progress) / 2.0), curved)
