"""What may not be ideal in a cell beside its faults: an arm's repeatability, shared or growing noise, small errors."""

from dataclasses import replace

import numpy as np

from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models.camera import HigherRadialDistortion, LensDecentring
from robolaser.trials.synthetic.fault_models.joint_loads import GearWindup
from robolaser.trials.synthetic.fault_models.joint_timing import PoseScatter
from robolaser.trials.synthetic.fault_models.joints import ShiftedZero
from robolaser.trials.synthetic.fault_models.links import LinkError
from robolaser.trials.world import World

IMAGE_PX = (0.5, 2.0)  # of a whole image, over the noise of a pixel
GROWTH = (2.0, 4.0)  # power of the range
OFFSET_RAD, PLACEMENT, WINDUP_RAD = 1e-4, 1e-4, 1e-4  # of a calibrated arm; a placement counts in metres and radians
K2, DECENTRING = 0.02, 2e-4  # of a calibrated lens


def scattering(world: World, rng: np.random.Generator) -> World:
    """An arm that repeats only so well, which nobody stated."""
    size = float(np.exp(rng.uniform(*np.log(PoseScatter.sizes))))
    return replace(world, scatter=PoseScatter.sample("arm", size, world.cell.run, rng))


def shared_noise(world: World, rng: np.random.Generator) -> World:
    """Images that are off as a whole."""
    return replace(world, image_px=float((world.noise.pixel_px or 0.0) * rng.uniform(*IMAGE_PX)))


def growing_noise(world: World, rng: np.random.Generator) -> World:
    """Noise that grows with the range."""
    return replace(world, growth=float(rng.uniform(*GROWTH)))


def small_errors(world: World, rng: np.random.Generator) -> World:
    """What calibration leaves of an arm and a lens: everything is off a little, and the faults stand out of it."""
    run = world.cell.run
    small: list[FaultModel] = []
    for joint in run.arm.joints:
        small.append(ShiftedZero(joint, float(OFFSET_RAD * rng.normal())))
        small.append(LinkError.sample(joint, float(PLACEMENT * rng.uniform(0.2, 1.0)), run, rng))
    for joint in GearWindup.locations(run):
        small.append(GearWindup.sample(joint, float(WINDUP_RAD * rng.uniform(0.1, 1.0)), run, rng))
    if world.noise.pixel_px is not None:
        small.append(HigherRadialDistortion.sample("camera", float(K2 * rng.uniform(0.1, 1.0)), run, rng))
        small.append(LensDecentring.sample("camera", float(DECENTRING * rng.uniform(0.1, 1.0)), run, rng))
    return replace(world, background=tuple(small))
