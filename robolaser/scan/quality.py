"""How good a cloud is: its own scatter, and primitives of known size measured in it."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import ScanError
from robolaser.scan.ply import Vertices, positions_of
from robolaser.scan.primitives import Primitive, find_plane, find_sphere, stands_out

STEP_SLACK = 0.5  # by which a step of known height may be off and still be taken for it
FAR_OFF = 3.0  # times that scatter and prediction may differ without a warning: few points alone make two
TINY = 1e-12  # metres: a prediction of zero is no divisor
LEVEL = 0.9  # share of points whose scatter is below what is reported beside the median


@final
@dataclass(frozen=True)
class Measured:
    """A primitive in the cloud compared with what is known of it."""

    what: str  # "plane", "step" or "sphere"
    size_m: float | None  # height of the step or radius of the sphere; None for a plane
    std_m: float | None  # its standard deviation, of points whose errors are independent
    known_m: float | None  # what it is
    rms_m: float  # scatter of its points about it
    predicted_m: float  # root-mean-square of these points' own `std`; NaN where that is not known
    points: int  # how many of those looked at lie on it

    @property
    def error_m(self) -> float | None:
        """Size found less size known."""
        return None if self.size_m is None or self.known_m is None else self.size_m - self.known_m


@final
@dataclass(frozen=True)
class Quality:
    """What is known of how good a cloud is."""

    vertices: Vertices  # the points looked at, (n,) of VERTEX
    scatter_m: float  # median of their `std`; NaN where it is not known
    most_m: float  # what LEVEL of them are below
    primitives: tuple[Measured, ...] = ()  # what was measured
    missing: tuple[ScanError, ...] = ()  # what was looked for in vain, and why, in the order wanted
    plane: Primitive | None = None  # the largest plane, where one was looked for

    @property
    def positions(self) -> Array:
        """Where they are, (n, 3) [m]."""
        return positions_of(self.vertices)

    @property
    def doubts(self) -> tuple[str, ...]:
        """A sentence for each primitive whose scatter is far from what its points' `std` predicts."""
        return tuple(filter(None, map(_doubt, self.primitives)))


def measure(
    vertices: Vertices,
    *,
    plane: bool = False,
    step_m: float | None = None,
    sphere_m: float | None = None,
    seed: int = 1,
) -> Quality:
    """Look for primitives of known size.

    Args:
        vertices: Points of a cloud, evenly taken.
        plane: Look for the largest plane.
        step_m: Look for a step of this height; it counts from the largest plane.
        sphere_m: Look for a sphere of this radius, among the points of neither step nor plane.
        seed: Of the samples drawn.
    """
    rng = np.random.default_rng(seed)
    xyz, std = positions_of(vertices), vertices["std"].astype(np.float64)
    known = std[np.isfinite(std)]
    scatter, most = (float(np.quantile(known, share)) if len(known) else float("nan") for share in (0.5, LEVEL))
    if not (plane or step_m or sphere_m):
        return Quality(vertices, scatter, most)
    largest = find_plane(xyz, std, rng)
    left = np.ones(len(xyz), dtype=bool) if largest is None else ~largest.on
    primitives: list[Measured] = []
    missing: list[ScanError] = []
    if largest is not None and (plane or step_m):
        primitives.append(_measured("plane", largest, std))
    elif plane:
        missing.append(_not_found("plane", "too few points lie on one"))
    if step_m:
        other = None if largest is None else _step(xyz, std, largest, step_m, rng)
        if largest is None or other is None:
            reason = f"too few points lie on a plane about {1e3 * step_m:.3g} mm off the largest one"
            missing.append(_not_found("step", reason))
        else:
            left &= ~other.on
            height, doubt = abs(other.size - largest.size), float(np.hypot(other.size_std, largest.size_std))
            primitives.append(_measured("step", other, std, height, doubt, step_m))
    if sphere_m:
        sphere = find_sphere(xyz[left], std[left], sphere_m, rng)
        if sphere is None or not stands_out(sphere.distance, sphere.on):
            beside = f"of {int(left.sum())} points beside the planes too few lie on one of radius"
            missing.append(_not_found("sphere", f"{beside} {1e3 * sphere_m:.3g} mm"))
        else:
            primitives.append(_measured("sphere", sphere, std[left], sphere.size, sphere.size_std, sphere_m))
    return Quality(vertices, scatter, most, tuple(primitives), tuple(missing), largest)


def _not_found(what: str, reason: str) -> ScanError:
    return ScanError(
        f"No {what} found in the cloud: {reason}. The cloud itself is written; leave the option out if nothing of the"
        " kind was scanned."
    )


def _step(xyz: Array, std: Array, plane: Primitive, height: float, rng: np.random.Generator) -> Primitive | None:
    """The other plane, parallel to the first, about as far off as is known."""
    there = ~plane.on & (np.abs(np.abs(plane.distance) - height) < STEP_SLACK * height)
    found = find_plane(xyz[there], std[there], rng, plane.place)
    if found is None:
        return None
    on = np.zeros(len(xyz), dtype=bool)
    on[np.flatnonzero(there)[found.on]] = True
    off = xyz @ found.place - found.size
    if not stands_out(off[~plane.on], on[~plane.on]):
        return None
    return replace(found, on=on, distance=off)


def _measured(what: str, found: Primitive, std: Array, *sizes: float) -> Measured:
    """A primitive with its size, the standard deviation of that and what it is known to be, or without sizes."""
    predicted = float(np.sqrt(np.mean(std[found.on] ** 2)))
    size, size_std, known = sizes or (None, None, None)
    return Measured(what, size, size_std, known, found.rms_m, predicted, int(found.on.sum()))


def _doubt(body: Measured) -> str:
    """A sentence where scatter and prediction, where there is one, are more than FAR_OFF apart."""
    if np.isnan(body.predicted_m) or 1 / FAR_OFF <= body.rms_m / max(body.predicted_m, TINY) <= FAR_OFF:
        return ""
    found = f"points scatter about the {body.what} by {1e3 * body.rms_m:.2g} mm"
    said = f"{found}, their std predicts {1e3 * body.predicted_m:.2g} mm"
    if body.rms_m > body.predicted_m:
        return f"{said}: the calibration does not fit this recording, or the surface does not have that shape."
    return (
        f"{said}: more than noise. Errors of the calibrated model count there as noise of the joints, but are"
        " common to neighbouring points."
    )
