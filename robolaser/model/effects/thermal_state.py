"""Progress of a warm-up in the course of a run, from 0 towards 1, and in another run."""

from dataclasses import dataclass

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import NOT_WARM, CarryOver, Effect, Run, RunSummary, nonlinear
from robolaser.model.effects.run import temperature_rise

SHORTEST, LONGEST, USUAL = 0.05, 3.0, 0.3  # time constant over the length of the run
EVEN = 1e-6  # settling, below which a creep is as good as even
TRIED = 6  # time constants; the curves of two neighbours agree to a few per cent


def warmed(run: Run, tau: Array) -> Array:
    """Rise of temperature over its largest where it was measured, else 1 - exp(-progress / tau), (c,) -> (c or 1, n).

    Source: Newton's law of cooling, towards a constant temperature.
    """
    return run.rise[None] if run.rise is not None else -np.expm1(-run.progress / tau[:, None])


def crept(progress: Array, settling: Array) -> Array:
    """Share of a creep that has happened, (n,) and (c,) -> (c, n): 0 at the start of the run and 1 at its end.

    :math:`(1 - e^{-s p}) / (1 - e^{-s})` of the progress p, where s is `settling`: even with 0.
    """
    even = settling[:, None] < EVEN
    rate = np.where(even, 1.0, settling[:, None])
    with np.errstate(over="ignore"):
        curved = np.expm1(-rate * progress) / np.expm1(-rate)
    return np.where(even, progress * (1.0 + settling[:, None] * (1.0 - progress) / 2.0), curved)


@dataclass(frozen=True)
class Warming(Effect):
    """A change in proportion to a rise of temperature."""

    depends_on_trajectory = True

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """It follows the thermometer of the other run; without one it stays as at the end of the first run."""
        by_thermometer = run.course is not None and run.course.by_thermometer
        return CarryOver(self) if by_thermometer else CarryOver(self, doubt=NOT_WARM, alternatives=(None,))


@dataclass(frozen=True)
class NewtonWarming(Warming):
    """One that settles with the time constant `tau` where no temperature was measured, see `warmed`."""

    tau: Array = nonlinear(unit="", lower=SHORTEST, upper=LONGEST, nominal=USUAL)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Time constants from a twentieth of the run to three runs; only one where temperatures were measured."""
        measured = temperature_rise(dataset.poses) is not None
        return np.array([[USUAL]]) if measured else np.geomspace(SHORTEST, LONGEST, TRIED)[:, None]
