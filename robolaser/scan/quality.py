"""How good a cloud is: its own scatter, and bodies of known size measured in it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.errors import SolidNotFound
from robolaser.scan.ply import Vertices, places_of
from robolaser.scan.solids import Plane, Sphere, find_plane, find_sphere, stands_out

STEP_SLACK = 0.5  # by which a step of known height may be off and still be taken for it
LEVEL = 0.9  # share of points whose scatter is below what is told beside the median


@final
@dataclass(frozen=True)
class Measured:
    """A body in the cloud against what is known of it.

    Attributes:
        what: "plane", "step" or "sphere".
        size_m: Height of the step or radius of the sphere; None for a plane.
        std_m: Its standard deviation, of points whose errors are independent.
        known_m: What it is.
        rms_m: Scatter of its points about it.
        promised_m: Root-mean-square of these points' own `std`; NaN where that is not known.
        points: How many of those looked at lie on it.
    """

    what: str
    size_m: float | None
    std_m: float | None
    known_m: float | None
    rms_m: float
    promised_m: float
    points: int

    @property
    def error_m(self) -> float | None:
        """Size found less size known."""
        return None if self.size_m is None or self.known_m is None else self.size_m - self.known_m


@final
@dataclass(frozen=True)
class Quality:
    """What is known of how good a cloud is.

    Attributes:
        vertices: The points looked at, (n,) of VERTEX.
        scatter_m: Median of their `std`; NaN where it is not known.
        most_m: What LEVEL of them are below.
        bodies: What was measured.
        plane: The largest plane, where one was looked for.
    """

    vertices: Vertices
    scatter_m: float
    most_m: float
    bodies: tuple[Measured, ...] = ()
    plane: Plane | None = None

    @property
    def places(self) -> Array:
        """Where they are, (n, 3) [m]."""
        return places_of(self.vertices)


def measure(
    vertices: Vertices, *, wanted: Sequence[str] = (), step_m: float = 0.0, sphere_m: float = 0.0, seed: int = 1
) -> Quality:
    """Look for bodies of known size.

    Args:
        vertices: Points of a cloud, evenly taken.
        wanted: Some of "plane", "step" and "sphere". A step counts from the largest plane; points of neither step nor
            plane may be the sphere's.
        step_m: Height of the step.
        sphere_m: Radius of the sphere.
        seed: Of the samples drawn.

    Raises:
        SolidNotFound: One of them is not there.
    """
    rng = np.random.default_rng(seed)
    xyz, std = places_of(vertices), vertices["std"].astype(np.float64)
    known = std[np.isfinite(std)]
    scatter, most = (float(np.quantile(known, share)) if len(known) else float("nan") for share in (0.5, LEVEL))
    if not wanted:
        return Quality(vertices, scatter, most)
    plane = find_plane(xyz, std, rng)
    bodies: list[Measured] = []
    left = np.ones(len(xyz), dtype=bool)
    if plane is not None:
        left &= ~plane.on
    if "plane" in wanted or "step" in wanted:
        if plane is None:
            raise SolidNotFound("plane", "too few points lie on one")
        bodies.append(Measured("plane", None, None, None, plane.rms_m, _promised(std, plane.on), int(plane.on.sum())))
    if "step" in wanted and plane is not None:
        other = _step(xyz, std, plane, step_m, rng)
        left &= ~other.on
        height, doubt = abs(other.offset - plane.offset), float(np.hypot(other.offset_std, plane.offset_std))
        bodies.append(
            Measured("step", height, doubt, step_m, other.rms_m, _promised(std, other.on), int(other.on.sum()))
        )
    if "sphere" in wanted:
        sphere = _sphere(xyz, std, left, sphere_m, rng)
        size, doubt = sphere.radius, sphere.radius_std
        promised = _promised(std[left], sphere.on)
        bodies.append(Measured("sphere", size, doubt, sphere_m, sphere.rms_m, promised, int(sphere.on.sum())))
    return Quality(vertices, scatter, most, tuple(bodies), plane)


def _step(xyz: Array, std: Array, plane: Plane, height: float, rng: np.random.Generator) -> Plane:
    """The other plane, parallel to the first, about as far off as is known."""
    there = ~plane.on & (np.abs(np.abs(plane.distance) - height) < STEP_SLACK * height)
    found = find_plane(xyz[there], std[there], rng, plane.normal)
    if found is not None:
        on = np.zeros(len(xyz), dtype=bool)
        on[np.flatnonzero(there)[found.on]] = True
        off = xyz @ found.normal - found.offset
    if found is None or not stands_out(off[~plane.on], on[~plane.on]):
        reason = f"too few points lie on a plane about {1e3 * height:.3g} mm off the largest one"
        raise SolidNotFound("step", reason)
    return Plane(found.normal, found.offset, found.offset_std, on, off)


def _sphere(xyz: Array, std: Array, left: Bools, radius: float, rng: np.random.Generator) -> Sphere:
    found = find_sphere(xyz[left], std[left], radius, rng)
    if found is None or not stands_out(found.distance, found.on):
        reason = f"of {int(left.sum())} points beside the planes too few lie on one of radius {1e3 * radius:.3g} mm"
        raise SolidNotFound("sphere", reason)
    return found


def _promised(std: Array, on: Bools) -> float:
    return float(np.sqrt(np.mean(std[on] ** 2)))
