"""Faults of the camera: its lens, and pixels that are far off."""

from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.trials.synthetic.fault_model import Angle, Coin, FaultModel
from robolaser.trials.synthetic.run import SyntheticRun

NEAREST_M, FOCUSED_M = 0.01, 0.25
FAR_PX = (2.0, 40.0)


def _third(where: str, run: SyntheticRun, rng: np.random.Generator) -> float:
    return float(rng.choice([0.0, rng.uniform(-2.0, 2.0)]))


@final
class HigherRadialDistortion(FaultModel, effect="radial_distortion", sizes=(0.05, 0.9), signed=True, location="camera"):
    """OpenCV's second and third radial terms: k2 is `size`, k3 in proportion."""

    third: Annotated[float, _third]  # k3 over k2

    def lens(self, terms: Array) -> Array:
        """With both terms."""
        return np.asarray(terms + np.array([0.0, self.size, 0.0, 0.0, self.third * self.size]))


@final
class LensDecentring(FaultModel, effect="tangential_distortion", sizes=(5e-4, 1e-2), location="camera"):
    """The lens's elements are not on one axis: OpenCV's p1 and p2."""

    towards: Angle

    def lens(self, terms: Array) -> Array:
        """Off to one side."""
        side = self.size * np.array([np.cos(self.towards), np.sin(self.towards)])
        return np.asarray(terms + np.array([0.0, 0.0, *side, 0.0]))


@final
class FocusDrive(FaultModel, effect="focus_breathing", sizes=(3e-3, 5e-2), signed=True, location="camera"):
    """Autofocus moves the lens along its axis: the image grows by the share `size` for each doubling of the depth."""

    def zoom(self, depth: Array) -> Array:
        """With the logarithm of the depth."""
        return np.asarray(self.size * np.log2(np.maximum(depth, NEAREST_M) / FOCUSED_M))


@final
class GrossErrors(FaultModel, effect="outliers", sizes=(0.01, 0.06), location="image"):
    """Glints and lost stripes: the share `size` of the points, or of their shots, is far off."""

    lasting: Coin  # whether all shots of a point are off, or only some

    def shots(self, pixel: Array, shot: Ints, rng: np.random.Generator) -> Array:
        """Off by 2 to 40 pixels, in any direction."""
        points = np.unique(shot)
        hit = np.isin(shot, points[rng.random(len(points)) < self.size])
        if not self.lasting:
            hit = rng.random(len(shot)) < self.size
        group = shot if self.lasting else np.arange(len(shot))
        way = rng.uniform(-np.pi, np.pi, len(shot))[group]
        far = np.exp(rng.uniform(np.log(FAR_PX[0]), np.log(FAR_PX[1]), len(shot)))[group]
        return np.asarray(pixel + np.where(hit, far, 0.0)[:, None] * np.stack([np.cos(way), np.sin(way)], axis=-1))
