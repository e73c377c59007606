"""What a departure of a true cell from its drawing is: a size, a form, and the places of the chain that it bends."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.trials.worlds.light import Light
from robolaser.trials.worlds.run import Run


@dataclass(frozen=True)
class Departure(ABC):
    """One flaw of one cell. What a subclass does not override passes unbent.

    Attributes:
        where: The place that truth names.
        size: Its principal number in SI units; the rest of it is form.
    """

    effect: ClassVar[str]
    sizes: ClassVar[tuple[float, float]]
    """Usual in industry, least and most."""

    where: str
    size: float

    @classmethod
    @abstractmethod
    def drawn(cls, where: str, size: float, run: Run, rng: np.random.Generator) -> Self:
        """One of this size, its form left to chance."""

    @classmethod
    @abstractmethod
    def places(cls, run: Run) -> tuple[str, ...]:
        """Where it can sit."""

    def joints(self, q: Array, run: Run) -> Array:
        """True joint angles, (n, j)."""
        return q

    def links(self, links: Array, run: Run) -> Array:
        """True placements of the joints, (n, j, 4, 4)."""
        return links

    def flange(self, T_base_flange: Array, run: Run) -> Array:
        """Where the flange truly is, (n, 4, 4)."""
        return T_base_flange

    def mount(self, T_flange_camera: Array, run: Run) -> Array:
        """Where the camera truly sits, (n, 4, 4)."""
        return T_flange_camera

    def lens(self, terms: Array) -> Array:
        """OpenCV's k1 k2 p1 p2 k3, (5,)."""
        return terms

    def light(self, light: Light, run: Run) -> Light:
        """The light as it truly spreads at each pose."""
        return light

    def height(self, along: Array, run: Run) -> Array:
        """How far the target stands out, (m,) [m], at places in it, (m, 2) [m] from its middle."""
        return np.zeros(len(along))

    def stripe(self, tilt: Array) -> Array:
        """How far the stripe's centre is read beside it, (m,) [px], by the surface's tilt [rad]."""
        return np.zeros_like(tilt)

    def printed(self, along: Array, run: Run) -> Array:
        """What the target's maker says of places in it, (m, 2) [m] from its middle."""
        return along

    def shots(self, pixel: Array, shot: Ints, rng: np.random.Generator) -> Array:
        """Pixels as read, (rows, 2) [px]; `shot` numbers each row's point."""
        return pixel
