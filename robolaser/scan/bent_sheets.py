"""Lenses and sheets that the compiled loop bends itself, as the rows of numbers that it takes."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect
from robolaser.model.effects.laser_curvature import LaserCurvature
from robolaser.model.effects.radial_distortion import RadialDistortion
from robolaser.model.effects.tangential_distortion import TangentialDistortion
from robolaser.model.stages import Stage
from robolaser.scan.lens_kinds import RADIAL, TANGENTIAL

SEAMS = (Stage.PIXELS, Stage.IMAGE, Stage.LIGHT)  # where each middle is bent by itself


def bent(effects: tuple[Effect, ...], dataset: Dataset) -> tuple[Array, Array] | None:
    """What `compiled.cloud.vertices` takes as `lens` and `light`; None where it cannot perturb what these effects do.

    Args:
        effects: In their order.
        dataset: Its nominal sheet is the one that a curved one bulges from.
    """
    lens: list[tuple[float, float, float]] = []
    light: list[tuple[float, float, float, float]] = []
    for effect in effects:
        if isinstance(effect, RadialDistortion):
            lens.append((RADIAL, effect.k_2[0], 0.0))
        elif isinstance(effect, TangentialDistortion):
            lens.append((TANGENTIAL, effect.p_1[0], effect.p_2[0]))
        elif isinstance(effect, LaserCurvature):
            theta = dataset.parameters["theta"].nominal
            light.append((effect.curvature[0], np.tan(effect.cone[0]), np.cos(theta), np.sin(theta)))
        elif effect.stage in SEAMS:
            return None
    return np.array(lens).reshape(-1, 3), np.array(light).reshape(-1, 4)
