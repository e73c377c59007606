"""A body that stands in a scene, stops rays and throws light back."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array


@final
@dataclass(frozen=True)
class Face:
    """A flat rectangle, or a whole plane.

    Attributes:
        middle: (3,) [m].
        normal: Outward, (3,).
        axes: Two unit vectors along its edges, (2, 3).
        half: Half its length along each, (2,) [m]; inf for a plane.
    """

    middle: Array
    normal: Array
    axes: Array
    half: Array


class Solid(ABC):
    """A body in the base frame.

    `shine` is the share of light that its surface mirrors, 0 to 1; the rest is thrown back to all sides.
    """

    shine: float

    @abstractmethod
    def hit(self, origin: Array, direction: Array) -> Array:
        """How far rays go until they meet the surface.

        Args:
            origin: Where they start, (..., 3) or (3,) [m].
            direction: Unit vectors, (..., 3).

        Returns:
            Distances, (...,) [m]; inf where they miss it.
        """

    @abstractmethod
    def normal(self, point: Array) -> Array:
        """Unit normals, outward, at points of the surface, (..., 3) -> (..., 3)."""

    @abstractmethod
    def albedo(self, point: Array, eye: Array, breadth: float) -> Array:
        """Share of light that is thrown back where rays of some breadth meet the surface.

        Args:
            point: Where, (..., 3) [m].
            eye: Where the rays come from, (3,) [m].
            breadth: Of a ray [rad]: edges of a print are blurred over it.

        Returns:
            From 0 to 1, (...,).
        """

    @abstractmethod
    def corners(self) -> Array | None:
        """Points whose convex hull holds the body, (k, 3) [m]; None: it has no end."""

    def plain(self) -> tuple[Array, float] | None:
        """Normal and albedo where both are the same everywhere; None where they are not."""
        return None

    def faces(self) -> tuple[Face, ...]:
        """Its flat sides, as far as they mirror."""
        return ()
