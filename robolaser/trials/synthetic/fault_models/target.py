"""Faults of the target."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class PrintScale(FaultModel):
    """The target was printed too large or too small: drawn distances are off by the share `size`."""

    effect: ClassVar[str] = "target_scale"
    sizes: ClassVar[tuple[float, float]] = (5e-4, 1.2e-2)
    signed: ClassVar[bool] = True
    location: ClassVar[str | None] = "target"

    aside: tuple[float, float]

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """The grid's origin, which lies somewhere on it."""
        return (tuple(rng.uniform(-0.5, 0.5, 2).tolist()),)

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's number."""
        return {"scale": self.size}

    def printed(self, along: Array, run: SyntheticRun) -> Array:
        """Scaled about the grid's origin."""
        origin = run.radius * np.array(self.aside)
        return origin + (along - origin) / (1.0 + self.size)


@final
@dataclass(frozen=True)
class FedTooFast(FaultModel):
    """The printer fed its paper too fast: the drawing is longer along that direction alone, by the share `size`."""

    effect: ClassVar[str] = "target_stretch"
    sizes: ClassVar[tuple[float, float]] = (1e-3, 1.5e-2)
    signed: ClassVar[bool] = True
    location: ClassVar[str | None] = "target"

    heading: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Which way [rad]."""
        return (rng.uniform(-np.pi, np.pi),)

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's number."""
        return {"stretch": self.size}

    def printed(self, along: Array, run: SyntheticRun) -> Array:
        """Shorter that way, as the drawing has it."""
        fed = np.array([np.cos(self.heading), np.sin(self.heading)])
        return np.asarray(along - (self.size / (1.0 + self.size) * (along @ fed))[:, None] * fed)


@final
@dataclass(frozen=True)
class CurvedTarget(FaultModel):
    """The target is not flat: a roof tile, a saddle or a wave."""

    effect: ClassVar[str] = "target_warp"
    sizes: ClassVar[tuple[float, float]] = (1e-4, 1.5e-3)
    location: ClassVar[str | None] = "target"

    form: str
    heading: float
    length: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Which of them, which way [rad], and the wave's length over the target's radius."""
        return str(rng.choice(["tile", "saddle", "wave"])), rng.uniform(-np.pi, np.pi), rng.uniform(1.5, 4.0)

    def height(self, along: Array, run: SyntheticRun) -> Array:
        """About `size` [m] at the rim."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        x, y = along[:, 0] / run.radius, along[:, 1] / run.radius
        x, y = cos * x + sin * y, cos * y - sin * x
        forms = {"tile": x**2, "saddle": x * y, "wave": np.sin(2 * np.pi * x / self.length)}
        height: Array = self.size * forms[self.form]
        return height


@final
@dataclass(frozen=True)
class TargetDent(FaultModel):
    """The target has a bell-shaped dent of some centimetres; the library has no such effect."""

    effect: ClassVar[str] = "dented_target"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 1.5e-3)
    location: ClassVar[str | None] = "target"
    classes: ClassVar[tuple[str, ...]] = ("target",)

    aside: tuple[float, float]
    width: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Where it lies, over the target's radius, and how wide it is [m]."""
        return tuple(rng.uniform(-0.5, 0.5, 2).tolist()), rng.uniform(0.03, 0.09)

    def height(self, along: Array, run: SyntheticRun) -> Array:
        """`size` [m] deep."""
        away = (along - run.radius * np.array(self.aside)) / self.width
        depth: Array = -self.size * np.exp(-0.5 * (away**2).sum(axis=1))
        return depth
