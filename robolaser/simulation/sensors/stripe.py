"""A simulated laser stripe scanner: the scanner of the 2004 paper on any arm, above a flat target."""

from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.stated_noise import Noise
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.forward_model import Model
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.placements import motion, named_parts
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values, as_batch
from robolaser.robot.visibility import View, configurations_looking_down
from robolaser.simulation.nominal import IMAGE_PX, built, facing_outward, scanner
from robolaser.simulation.sensors.simulated_sensor import (
    EXACT_M,
    ROUNDS,
    SimulatedSensor,
    moved_within,
    nominal_points,
    with_errors,
)
from robolaser.simulation.setup import Effects, RandomStreams, SensorSetup

JITTER = 0.6  # of the distance between points along the stripe
TILT_RAD = 0.02  # an unplaced target is tilted by this at most
SECANT_STEPS = 40
FIRST_STRIDE_PX = 0.5
IMAGE_MARGIN = 0.02  # of the image, so that noise does not carry a pixel out of it
GROSS_PX = (10.0, 60.0)  # across the stripe: a reflection is mistaken for it


@final
@dataclass(frozen=True)
class SimulatedStripe(SimulatedSensor):
    """A scanner that looks down on a target."""

    kind: ClassVar[str] = "stripe"
    default_points: ClassVar[int] = 12
    own_noise: ClassVar[tuple[str, str]] = ("pixel", "pixel_px")

    view: View  # its view
    at: Array  # pixel coordinates along the stripe, (n, k)
    level: float  # height of the target in the base frame, or in its own one where it is not placed [m]

    @classmethod
    def describe(cls, dataset: Dataset, setup: SensorSetup) -> Dataset:
        """With the nominal scanner, its bracket and its image."""
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
        view = scanner_geometry.view_of(dataset, as_batch(truth))
        candidates, level = configurations_looking_down(robot, view, wanted=n, rng=random.place)
        first, last = view.stripe_range()
        step = (last - first) / points
        at = first + step * (np.arange(points) + 0.5 + JITTER * random.along.uniform(-0.5, 0.5, (n, points)))
        if not dataset.placed:
            middle = robot.forward(candidates[:n])[:, :2, 3].mean(axis=0)
            tilt = random.place.uniform(-1, 1, 3) * (TILT_RAD, TILT_RAD, np.pi)
            truth |= named_parts("target", (*middle, level, *tilt))
            level = 0.0
        return cls(truth, candidates, view, at, level)

    def measure(self, dataset: Dataset, chosen: Ints, values: Values, effects: Effects) -> tuple[Dataset, Bools]:
        """Follow the stripe along the target: for each point along it, the pixel that shows the target.

        Points are on a plane, as the target's maker would state them. A pose is good if it shows all its points.
        """
        n, k = self.at.shape
        along = self.view.along
        T_base_target = np.eye(4) if dataset.placed else motion(values, "target")[0]
        camera = dataset.flange() @ self.view.T_flange_camera
        pixel = self.view.stripe(camera, float(T_base_target[2, 3] + self.level), self.at).reshape(-1, 2)
        names = tuple(str(i) for _ in range(n) for i in range(k))
        points = Points(np.repeat(np.arange(n), k), names, pixel=pixel, xyz=np.zeros((n * k, 3)))
        dataset = replace(dataset, points=points)
        plain = Model(dataset)
        shown = scanner_geometry.in_base(dataset, values, plain.flange(values), plain.perturb(values))[0]
        given = apply(inverse(T_base_target), shown)
        for _ in range(ROUNDS):
            dataset = replace(dataset, points=replace(points, pixel=pixel, xyz=given))
            model = Model(dataset, effects)
            perturb = model.perturb(values)
            T = model.flange(values, perturb)
            left = np.abs(model.blocks.residuals(values, T, perturb))[0].max(axis=-1)
            left = np.maximum(left, np.abs(given[:, 2] - self.level))
            if (left < EXACT_M).all():
                break
            pixel, given = _on_target(dataset, values, T, perturb, pixel, 1 - along, T_base_target, self.level)
        shown = scanner_geometry.in_camera(dataset.points["pixel"][None], values, perturb, dataset.stripe_axis)[0]
        good = (left < EXACT_M) & self.view.contains(pixel, IMAGE_MARGIN) & (shown[:, 2] > 0)
        return dataset, np.asarray(good.reshape(n, k).all(axis=1))

    @classmethod
    def add_shared_noise(cls, points: Points, noise: Noise, rng: np.random.Generator) -> Points:
        """Errors of the target."""
        return with_errors(points, "xyz", noise.target_m, rng)

    @classmethod
    def add_gross_errors(cls, dataset: Dataset, rows: Ints, sign: Array, rng: np.random.Generator) -> Dataset:
        """Pixels across the stripe."""
        across = 1 if dataset.stripe_axis == "u" else 0
        pixel = dataset.points["pixel"].copy()
        largest = IMAGE_PX[across] - 1.0
        pixel[rows, across] = moved_within(pixel[rows, across], sign * rng.uniform(*GROSS_PX, len(rows)), 0.0, largest)
        return replace(dataset, points=replace(dataset.points, pixel=pixel))


def _on_target(
    dataset: Dataset,
    values: Values,
    T_base_flange: Array,
    perturb: Perturbation,
    pixel: Array,
    across: int,
    T_base_target: Array,
    level: float,
) -> tuple[Array, Array]:
    """Move each pixel across the stripe, by the secant method, until its point is on the target."""
    T_target_base = inverse(T_base_target)

    def off(moved: Array) -> tuple[Array, Array]:
        there = pixel.copy()
        there[:, across] = moved
        shown = scanner_geometry.in_base(dataset, values, T_base_flange, perturb, pixel=there[None])[0]
        given = nominal_points(apply(T_target_base, shown), perturb)
        return given[:, 2] - level, given

    before = pixel[:, across]
    now = before + FIRST_STRIDE_PX
    off_before, _ = off(before)
    off_now, given = off(now)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for _ in range(SECANT_STEPS):
            slope = (off_now - off_before) / (now - before)
            step = np.where(off_now == off_before, 0.0, -off_now / slope)
            before, off_before = now, off_now
            now = now + step
            off_now, given = off(now)
            if (np.abs(off_now) < EXACT_M / 100).all():
                break
    found = pixel.copy()
    found[:, across] = now
    given[:, 2] = level
    return found, given
