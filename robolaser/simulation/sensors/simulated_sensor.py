"""A sensor in a simulated cell: its construction, its possible poses, its measurements and its errors."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.stated_noise import Noise
from robolaser.errors import UsageError
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values
from robolaser.simulation.setup import Effects, RandomStreams, SensorSetup

EXACT_M = 1e-12
ROUNDS = 8  # effects may depend on the points that they perturb: repeat to convergence
INVERSION_STEPS = 60
REGISTERED: dict[str, "type[SimulatedSensor]"] = {}  # simulated sensors by kind; a subclass enters itself


@dataclass(frozen=True)
class SimulatedSensor(ABC):
    """A sensor of one kind in one cell."""

    kind: ClassVar[str]  # as in `[sensor] kind`
    default_points: ClassVar[int] = 3  # default of points in each pose, or names of points

    own_noise: ClassVar[tuple[str, str]] = ("", "")  # the array of points with each row's error, and its size in Noise

    truth: Mapping[str, float]  # every parameter of the sensor by name, as the cell was built
    candidates: Array  # configurations in which the nominal arm can measure, at least as many as poses, (≥ n, j)

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        REGISTERED[cls.kind] = cls

    @classmethod
    def check_counts(cls, *, poses: int, points: int, repeats: int) -> None:
        """Raise a `UsageError` if the sensor cannot measure so often."""
        for what, count in (("poses", poses), ("points", points), ("repeats", repeats)):
            if count < 1:
                raise impossible(f"number of {what}", count, "1 or more")

    @classmethod
    def describe(cls, dataset: Dataset, setup: SensorSetup) -> Dataset:
        """The data set, still without points, with its statements on the sensor."""
        return dataset

    @classmethod
    @abstractmethod
    def build(cls, dataset: Dataset, setup: SensorSetup, random: RandomStreams) -> Self:
        """Draw the true sensor and configurations that suit it.

        Args:
            dataset: As described; its poses are still in the middle of the joint limits.
            setup: The request.
            random: `build` for the sensor, `place` for configurations and targets, `along` for points on a stripe.

        Raises:
            RobotError: The arm cannot measure often enough.
        """

    @abstractmethod
    def measure(self, dataset: Dataset, chosen: Ints, values: Values, effects: Effects) -> tuple[Dataset, Bools]:
        """The sensor's measurements without noise.

        Args:
            dataset: Poses in some of the candidates, without points.
            chosen: Which candidate each pose is, (n,).
            values: All parameters and the effects' numbers, one candidate.
            effects: The effects of the cell.

        Returns:
            The data set with points, and in which poses the sensor could measure, (n,).
        """

    @classmethod
    def add_shared_noise(cls, points: Points, noise: Noise, rng: np.random.Generator) -> Points:
        """Add the errors that the repeats of a point share."""
        return points

    @classmethod
    def add_noise(cls, points: Points, noise: Noise, rng: np.random.Generator) -> Points:
        """Add the independent errors of rows: by default those of `own_noise`."""
        array, sigma = cls.own_noise
        return with_errors(points, array, getattr(noise, sigma), rng) if array else points

    @classmethod
    @abstractmethod
    def add_gross_errors(cls, dataset: Dataset, rows: Ints, sign: Array, rng: np.random.Generator) -> Dataset:
        """Put typical gross errors of this sensor into some rows, each to the side of its sign (±1)."""


def with_errors(points: Points, array: str, sigma: float | None, rng: np.random.Generator) -> Points:
    """Points with errors of this size in one of their arrays; unchanged without any."""
    if sigma is None:
        return points
    shaken = points[array] + sigma * rng.normal(size=points[array].shape)
    return points.with_arrays({**points.arrays, array: shaken})


def impossible(what: str, value: object, expected: str) -> UsageError:
    """The error of an impossible value of a simulated cell."""
    return UsageError(f"A cell cannot be simulated with {what} {value!r}: expected {expected}.")


def moved_within(value: Array, by: Array, lower: Array | float, upper: Array | float) -> Array:
    """Values moved by some step, or its opposite where it leaves the bounds."""
    there = value + by
    return np.where((there < lower) | (there > upper), value - by, there)


def seen_by_tracker(dataset: Dataset, points: Points, seen: Callable[[Points], Points]) -> tuple[Dataset, Bools]:
    """A tracker's measurements by `seen`, repeated from initial points, on which effects depend, to convergence."""
    for _ in range(ROUNDS):
        before, points = points["xyz"], seen(points)
        if (np.abs(points["xyz"] - before) < EXACT_M).all():
            break
    whole = np.isfinite(points["xyz"]).reshape(len(dataset.poses), -1).all(axis=1)
    return replace(dataset, points=points), np.asarray(whole)


def nominal_points(there: Array, perturb: Perturbation) -> Array:
    """The target points that effects move to the true ones, (m, 3) -> (m, 3) [m]; by fixed-point iteration."""
    nominal = there
    for _ in range(INVERSION_STEPS):
        missing = there - perturb(Stage.TARGET, nominal[None])[0]
        nominal = nominal + missing
        if not (np.abs(missing) > EXACT_M / 1000).any():
            break
    return nominal
