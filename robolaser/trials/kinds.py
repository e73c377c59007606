"""The kinds of worlds in a blind trial: their faults and other imperfections."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.errors import UsageError, near
from robolaser.trials.building import World
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models import DRAWN, FAULT_MODELS, OUTLIERS, PHYSICAL, UNMODELLED
from robolaser.trials.synthetic.fault_models.joints import PoseScatter, ShiftedZero
from robolaser.trials.synthetic.fault_models.links import LinkError
from robolaser.trials.synthetic.fault_models.loads import GearWindup
from robolaser.trials.synthetic.fault_models.scanner import HigherRadialDistortion, LensDecentring
from robolaser.trials.synthetic.mujoco_arm import mujoco

SHIFT = (0.5, 2.0)  # of a whole image, over the noise of a pixel
GROWTH = (2.0, 4.0)  # power of the range
OFFSET_RAD, PLACEMENT, WINDUP_RAD = 1e-4, 1e-4, 1e-4  # of a calibrated arm; placements are in metres and radians
K2, DECENTRING = 0.02, 2e-4  # of a calibrated lens
BESIDE_UNKNOWN = 0.4  # share of worlds with an unknown cause that also have a library effect


@final
@dataclass(frozen=True)
class Kind:
    """Random properties of a kind of worlds."""

    number: tuple[int, int] = (0, 0)  # least and most number of faults
    among: tuple[str, ...] = DRAWN  # names of possible faults
    beside: float = 0.0  # probability of an additional library effect
    outliers: float = 0.0  # probability of additional gross errors
    imperfection: Callable[[World, np.random.Generator], World] | None = None  # other than faults
    misstated: bool = False  # whether the stated noise is wrong
    tracked: bool = False  # whether a tracker measures the arm, instead of a scanner on it
    share: float = 0.0  # of the worlds, where no kinds are requested


def scattering(world: World, rng: np.random.Generator) -> World:
    """An arm with an unstated repeatability."""
    size = float(np.exp(rng.uniform(*np.log(PoseScatter.sizes))))
    return replace(world, scatter=PoseScatter.sample("arm", size, world.cell.run, rng))


def small_errors(world: World, rng: np.random.Generator) -> World:
    """Residual errors of a calibrated arm and lens, everywhere, smaller than the faults."""
    run = world.cell.run
    small: list[FaultModel] = []
    for joint in run.joints:
        small.append(ShiftedZero(joint, float(OFFSET_RAD * rng.normal())))
        small.append(LinkError.sample(joint, float(PLACEMENT * rng.uniform(0.2, 1.0)), run, rng))
    for joint in GearWindup.locations(run):
        small.append(GearWindup.sample(joint, float(WINDUP_RAD * rng.uniform(0.1, 1.0)), run, rng))
    if world.noise.pixel_px is not None:
        small.append(HigherRadialDistortion.sample("camera", float(K2 * rng.uniform(0.1, 1.0)), run, rng))
        small.append(LensDecentring.sample("camera", float(DECENTRING * rng.uniform(0.1, 1.0)), run, rng))
    return replace(world, background=tuple(small))


KINDS: dict[str, Kind] = {
    "none": Kind(share=0.1),
    "single": Kind((1, 1), outliers=0.12, share=0.3),
    "pair": Kind((2, 2), outliers=0.12, share=0.08),
    "triple": Kind((3, 3), outliers=0.12, share=0.03),
    "several": Kind((3, 4), share=0.04),
    "unknown": Kind((1, 1), UNMODELLED, beside=BESIDE_UNKNOWN, share=0.1),
    "outliers": Kind((1, 1), (OUTLIERS,), share=0.05),
    "repeatability": Kind((0, 1), imperfection=scattering, share=0.1),
    "misstated_noise": Kind((0, 1), misstated=True, share=0.05),
    "shared_noise": Kind(
        (0, 1),
        imperfection=lambda world, rng: replace(world, image_px=(world.noise.pixel_px or 0.0) * rng.uniform(*SHIFT)),
        share=0.05,
    ),
    "growing_noise": Kind(
        (0, 1), imperfection=lambda world, rng: replace(world, growth=rng.uniform(*GROWTH)), share=0.03
    ),
    "small_errors": Kind((1, 1), imperfection=small_errors, share=0.05),
    "tracker": Kind(tracked=True, share=0.05),
    "physics": Kind((0, 1), PHYSICAL),
}
"""Kinds by name. A fault's name is a kind, too: worlds with this fault alone. MuJoCo is an extra, so its kinds have
no share."""
USUAL = {name: kind.share for name, kind in KINDS.items() if kind.share}  # share of each kind where none is requested
IN_IMAGES = ("outliers", "shared_noise")  # kinds without a counterpart for trackers
TRACKED = ("none", "single", "several", "repeatability", "growing_noise", "small_errors", "unknown")
"""Faults of an arm that a tracker measures."""


def kinds_of(names: Iterable[str]) -> tuple[str, ...]:
    """The names, checked to be kinds.

    Raises:
        UsageError: Not one of `KINDS`, nor a fault.
        DependencyMissing: MuJoCo moves some of them, and is not installed.
    """
    for name in (names := tuple(names)):
        if name not in KINDS and name not in FAULT_MODELS:
            raise UsageError(f"No kind of world '{name}'.{near(name, dict.fromkeys((*KINDS, *FAULT_MODELS)))}")
    if {"physics", *PHYSICAL} & {*names}:
        mujoco()
    return names


def drawn(name: str, rng: np.random.Generator) -> Kind:
    """The random properties of a world of a kind; raises as `kinds_of`."""
    (name,) = kinds_of([name])
    kind = KINDS.get(name) or Kind((1, 1), (name,))
    return replace(KINDS[str(rng.choice(TRACKED))], tracked=True, outliers=0.0) if name == "tracker" else kind
