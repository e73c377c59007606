"""Faults of the camera's lens."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun

NEAREST_M, FOCUSED_M = 0.01, 0.25


@final
@dataclass(frozen=True)
class HigherRadialDistortion(FaultModel):
    """OpenCV's second and third radial terms: k2 is `size`, k3 in proportion."""

    effect: ClassVar[str] = "radial_distortion"
    sizes: ClassVar[tuple[float, float]] = (0.05, 0.9)
    signed: ClassVar[bool] = True
    location: ClassVar[str | None] = "camera"

    third: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """k3 over k2."""
        return (rng.choice([0.0, rng.uniform(-2.0, 2.0)]),)

    def lens(self, terms: Array) -> Array:
        """With both terms."""
        distorted: Array = terms + np.array([0.0, self.size, 0.0, 0.0, self.third * self.size])
        return distorted


@final
@dataclass(frozen=True)
class LensDecentring(FaultModel):
    """The lens's elements are not on one axis: OpenCV's p1 and p2."""

    effect: ClassVar[str] = "tangential_distortion"
    sizes: ClassVar[tuple[float, float]] = (5e-4, 1e-2)
    location: ClassVar[str | None] = "camera"

    towards: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Any direction."""
        return (rng.uniform(-np.pi, np.pi),)

    def lens(self, terms: Array) -> Array:
        """Off to one side."""
        side = self.size * np.array([np.cos(self.towards), np.sin(self.towards)])
        distorted: Array = terms + np.array([0.0, 0.0, *side, 0.0])
        return distorted


@final
@dataclass(frozen=True)
class FocusDrive(FaultModel):
    """Autofocus moves the lens along its axis: the image grows by the share `size` for each doubling of the depth."""

    effect: ClassVar[str] = "focus_breathing"
    sizes: ClassVar[tuple[float, float]] = (3e-3, 5e-2)
    signed: ClassVar[bool] = True
    location: ClassVar[str | None] = "camera"

    def zoom(self, depth: Array) -> Array:
        """With the logarithm of the depth."""
        return np.asarray(self.size * np.log2(np.maximum(depth, NEAREST_M) / FOCUSED_M))
