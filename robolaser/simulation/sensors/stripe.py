"""A simulated laser stripe scanner: the scanner of the 2004 paper on any arm, above a flat target."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.stated_noise import Noise
from robolaser.geometry.rigid_motion import from_angles, from_quaternion, pose
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.sensors.placements import SIX
from robolaser.parameters import Values
from robolaser.robot.visibility import View, configurations_looking_down
from robolaser.simulation.nominal import IMAGE_PX, built, facing_outward, scanner
from robolaser.simulation.outliers import moved_within
from robolaser.simulation.sensors.simulated_sensor import SimulatedSensor
from robolaser.simulation.sensors.stripe_points import stripe_points
from robolaser.simulation.setup import RandomStreams, SensorSetup

JITTER = 0.6  # of the distance between points along the stripe
TILT_RAD = 0.02  # an unplaced target is tilted by this at most
GROSS_PX = (10.0, 60.0)  # across the stripe: a reflection is taken for it


@final
@dataclass(frozen=True)
class SimulatedStripe(SimulatedSensor):
    """A scanner that looks down on a target."""

    kind: ClassVar[str] = "stripe"
    default_points: ClassVar[int] = 12

    view: View  # what it sees
    at: Array  # pixel coordinates along the stripe, (n, k)
    level: float  # height of the target in the base frame, or in its own one where it is not placed [m]

    @classmethod
    def describe(cls, dataset: Dataset, setup: SensorSetup) -> Dataset:
        """With the drawing of the scanner, its bracket and its image."""
        bracket = facing_outward(dataset.arm[0]) if setup.options.bracket_quat is None else setup.options.bracket_quat
        return replace(
            dataset,
            placed=setup.options.placed,
            stripe_axis=setup.options.stripe_axis,
            bracket_quat=bracket,
            image_px=IMAGE_PX,
            parameters=scanner(bracket),
        )

    @classmethod
    def build(cls, dataset: Dataset, setup: SensorSetup, random: RandomStreams) -> Self:
        """A scanner within the tolerances of `nominal.BUILT`."""
        (robot, _), n, points = dataset.arm, len(dataset.poses), setup.points
        truth = built(dataset.parameters, random.build)
        view = View(_mount(dataset, truth), truth, dataset.stripe_axis, IMAGE_PX)
        candidates, level = configurations_looking_down(
            robot, view, wanted=n, level=setup.options.level, rng=random.place
        )
        first, last = view.stripe_range()
        step = (last - first) / points
        at = first + step * (np.arange(points) + 0.5 + JITTER * random.along.uniform(-0.5, 0.5, (n, points)))
        if not dataset.placed:
            middle = robot.forward(candidates[None, :n])[0, :, :2, 3].mean(axis=0)
            tilt = random.place.uniform(-1, 1, 3) * (TILT_RAD, TILT_RAD, np.pi)
            truth |= {f"target.{part}": float(value) for part, value in zip(SIX, (*middle, level, *tilt), strict=True)}
            level = 0.0
        return cls(truth, candidates, view, at, level)

    def measure(
        self, dataset: Dataset, chosen: Ints, values: Values, candidate_effects: Sequence[CandidateEffect]
    ) -> tuple[Dataset, Bools]:
        """Pixels of the stripe and the target points that they show; a pose is good if it shows all of its points."""
        return stripe_points(dataset, candidate_effects, values, view=self.view, at=self.at, level=self.level)

    @classmethod
    def add_shared_noise(cls, points: Points, noise: Noise, rng: np.random.Generator) -> Points:
        """Errors of the target."""
        if noise.target_m is None:
            return points
        return replace(points, xyz=points["xyz"] + noise.target_m * rng.normal(size=points["xyz"].shape))

    @classmethod
    def add_noise(cls, points: Points, noise: Noise, rng: np.random.Generator) -> Points:
        """Errors of the line's centre."""
        if noise.pixel_px is None:
            return points
        return replace(points, pixel=points["pixel"] + noise.pixel_px * rng.normal(size=points["pixel"].shape))

    @classmethod
    def add_gross_errors(cls, dataset: Dataset, rows: Ints, sign: Array, rng: np.random.Generator) -> Dataset:
        """Pixels across the stripe."""
        across = 1 if dataset.stripe_axis == "u" else 0
        pixel = dataset.points["pixel"].copy()
        largest = IMAGE_PX[across] - 1.0
        pixel[rows, across] = moved_within(pixel[rows, across], sign * rng.uniform(*GROSS_PX, len(rows)), 0.0, largest)
        return replace(dataset, points=replace(dataset.points, pixel=pixel))


def _mount(dataset: Dataset, truth: dict[str, float]) -> Array:
    """T_flange_camera, (4, 4)."""
    turn = from_angles(*(np.array(truth[angle]) for angle in ("w", "phi", "psi")))
    shift = np.array([truth[f"t_{axis}"] for axis in "xyz"])
    return pose(from_quaternion(np.array(dataset.bracket_quat)) @ turn, shift)
