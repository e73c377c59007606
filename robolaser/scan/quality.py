"""Quality of a cloud: its scatter, and planes and spheres of known size, found by random samples and fitted."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.errors import ScanError
from robolaser.geometry.mad_scale import mad_scale
from robolaser.scan.ply import Vertices, positions_of

STEP_SLACK = 0.5  # relative tolerance of a step of known height
FAR_OFF = 3.0  # factor between scatter and prediction without a warning: few points alone cause two
TINY = 1e-12  # metres: a prediction of zero is no divisor
LEVEL = 0.9  # quantile of scatter that is reported with the median
DRAWS = 600  # samples of points: with a fifth of these on the primitive, one is clean in 99 of 100 cases
JUDGES = 4000  # points by which samples are judged
NEAR_STD = 3.0  # distance in scatters within which a point may belong to a primitive
LEAST_NEAR_M = 2e-4  # least such distance: the usual error of calibrations
ROUNDS = 10  # of fitting and leaving out
FEWEST = 30  # points that determine a primitive
FLOOR = 0.2  # of the median scatter: least scatter in a point's weight
CLEAR = 0.75  # share of the points within three times the tolerance that are on a real primitive
RADIUS_SLACK = 0.3  # relative tolerance of a sphere of known radius


@final
@dataclass(frozen=True)
class Primitive:
    """A flat or a round part of a cloud."""

    place: Array  # a plane's unit normal, positive along its nearest axis; a sphere's centre [m], (3,)
    size: float  # the plane's offset along its normal: normal · P = offset; the sphere's radius [m]
    size_std: float  # standard deviation, for independent errors of points [m]
    on: Bools  # whether each point is on it, (n,)
    distance: Array  # of all points from it, (n,) [m]

    @property
    def rms_m(self) -> float:
        """Scatter of its points about it."""
        return float(np.sqrt(np.mean(self.distance[self.on] ** 2)))


@final
@dataclass(frozen=True)
class Measured:
    """A primitive in the cloud compared with its known size."""

    what: str  # "plane", "step" or "sphere"
    size_m: float | None  # height of the step or radius of the sphere; None for a plane
    std_m: float | None  # its standard deviation, for independent errors of points
    known_m: float | None  # true size
    rms_m: float  # scatter of its points about it
    predicted_m: float  # RMS of these points' `std`; NaN where that is not known
    points: int  # number of its points

    @property
    def error_m(self) -> float | None:
        """Measured less true size."""
        return None if self.size_m is None or self.known_m is None else self.size_m - self.known_m


@final
@dataclass(frozen=True)
class Quality:
    """Measured quality of a cloud."""

    vertices: Vertices  # the sampled points, (n,) of VERTEX
    scatter_m: float  # median of their `std`; NaN where it is not known
    most_m: float  # LEVEL quantile of them
    primitives: tuple[Measured, ...] = ()  # measured ones
    missing: tuple[ScanError, ...] = ()  # reasons for primitives that were not found, in order
    plane: Primitive | None = None  # the largest plane, if requested

    @property
    def positions(self) -> Array:
        """Positions of the points, (n, 3) [m]."""
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
    """Measure scatter and primitives of known size.

    Args:
        vertices: Points of a cloud, evenly taken.
        plane: Measure the largest plane.
        step_m: Measure a step of this height on the largest plane.
        sphere_m: Measure a sphere of this radius, among the points of neither step nor plane.
        seed: Of the random samples.
    """
    rng = np.random.default_rng(seed)
    xyz, std = positions_of(vertices), vertices["std"].astype(np.float64)
    known = std[np.isfinite(std)]
    scatter, most = (float(np.quantile(known, share)) if len(known) else float("nan") for share in (0.5, LEVEL))
    if not (plane or step_m or sphere_m):
        return Quality(vertices, scatter, most)
    largest = _find_plane(xyz, std, rng)
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
        sphere = _find_sphere(xyz[left], std[left], sphere_m, rng)
        if sphere is None or not _stands_out(sphere.distance, sphere.on):
            few = f"of {int(left.sum())} points beside the planes too few lie on one of radius"
            missing.append(_not_found("sphere", f"{few} {1e3 * sphere_m:.3g} mm"))
        else:
            primitives.append(_measured("sphere", sphere, std[left], sphere.size, sphere.size_std, sphere_m))
    return Quality(vertices, scatter, most, tuple(primitives), tuple(missing), largest)


def _not_found(what: str, reason: str) -> ScanError:
    return ScanError(
        f"No {what} found in the cloud: {reason}. The cloud itself is written; leave the option out if nothing of the"
        " kind was scanned."
    )


def _step(xyz: Array, std: Array, plane: Primitive, height: float, rng: np.random.Generator) -> Primitive | None:
    """The other plane, parallel to the first, at about the known distance."""
    there = ~plane.on & (np.abs(np.abs(plane.distance) - height) < STEP_SLACK * height)
    found = _find_plane(xyz[there], std[there], rng, plane.place)
    if found is None:
        return None
    on = np.zeros(len(xyz), dtype=bool)
    on[np.flatnonzero(there)[found.on]] = True
    off = xyz @ found.place - found.size
    if not _stands_out(off[~plane.on], on[~plane.on]):
        return None
    return replace(found, on=on, distance=off)


def _measured(what: str, found: Primitive, std: Array, *sizes: float) -> Measured:
    """A primitive with its size, standard deviation and true size, or without sizes."""
    predicted = float(np.sqrt(np.mean(std[found.on] ** 2)))
    size, size_std, known = sizes or (None, None, None)
    return Measured(what, size, size_std, known, found.rms_m, predicted, int(found.on.sum()))


def _doubt(body: Measured) -> str:
    """A sentence where scatter and prediction, where there is one, are more than FAR_OFF apart."""
    if np.isnan(body.predicted_m) or 1 / FAR_OFF <= body.rms_m / max(body.predicted_m, TINY) <= FAR_OFF:
        return ""
    found = f"points scatter about the {body.what} by {1e3 * body.rms_m:.2g} mm"
    compared = f"{found}, their std predicts {1e3 * body.predicted_m:.2g} mm"
    if body.rms_m > body.predicted_m:
        return f"{compared}: the calibration does not fit this recording, or the surface does not have that shape."
    return (
        f"{compared}: more than noise. Errors of the calibrated model count there as noise of the joints, but are"
        " common to neighbouring points."
    )


def _find_plane(xyz: Array, std: Array, rng: np.random.Generator, normal: Array | None = None) -> Primitive | None:
    """The plane with the most points (n, 3), with a given normal (3,) or any; None where it has too few points."""
    if len(xyz) < FEWEST:
        return None
    _, near = _scales(std)
    drawn = xyz[rng.integers(len(xyz), size=(DRAWS, 3))]
    if normal is None:
        normals = np.cross(drawn[:, 1] - drawn[:, 0], drawn[:, 2] - drawn[:, 0])
        length = np.linalg.norm(normals, axis=-1, keepdims=True)
        normals, drawn = normals[length[:, 0] > 0] / length[length[:, 0] > 0], drawn[length[:, 0] > 0]
        if not len(normals):  # all points lie on one line
            return None
    else:
        normals = np.broadcast_to(normal, (DRAWS, 3))
    offsets = (normals * drawn[:, 0]).sum(axis=-1)
    some = rng.integers(len(xyz), size=min(len(xyz), JUDGES))
    misses = np.abs(normals @ xyz[some].T - offsets[:, None])
    best = int(np.minimum(misses / near[some], 1.0).sum(axis=1).argmin())
    return _refined_plane(xyz, std, normals[best], float(offsets[best]), free=normal is None)


def _refined_plane(xyz: Array, std: Array, normal: Array, offset: float, *, free: bool) -> Primitive | None:
    weight, near = _scales(std)
    on = np.abs(xyz @ normal - offset) < near
    for _ in range(ROUNDS):
        if on.sum() < FEWEST:
            return None
        w = weight[on] / weight[on].sum()
        middle = w @ xyz[on]
        if free:
            about = xyz[on] - middle
            normal = np.linalg.eigh((w[:, None] * about).T @ about)[1][:, 0]
        offset = float(normal @ middle)
        off = xyz @ normal - offset
        before, on = on, np.abs(off) < np.maximum(near, NEAR_STD * mad_scale(off[on]))
        if np.array_equal(before, on):
            break
    if free and normal[np.abs(normal).argmax()] < 0:
        normal, offset, off = -normal, -offset, -off
    w = weight[on] / weight[on].sum()
    return Primitive(normal, offset, float(np.sqrt((w**2) @ off[on] ** 2)), on, off)


def _find_sphere(xyz: Array, std: Array, radius: float, rng: np.random.Generator) -> Primitive | None:
    """The sphere of about a known radius [m] with the most points (n, 3); None where it has fewer than FEWEST."""
    if len(xyz) < FEWEST:
        return None
    from scipy.spatial import cKDTree  # noqa: PLC0415 - loaded when needed: scipy is slow to import

    _, near = _scales(std)
    some = rng.permutation(len(xyz))[:JUDGES]
    around = cKDTree(xyz[some]).query_ball_point(xyz[rng.integers(len(xyz), size=DRAWS)], 2 * radius)
    fours = np.array([rng.choice(few, 4, replace=False) for few in np.atleast_1d(around) if len(few) >= 4])
    if not len(fours):
        return None
    centres, radii = _through(xyz[some][fours])
    fits = np.abs(radii - radius) < RADIUS_SLACK * radius
    if not fits.any():
        return None
    apart = np.linalg.norm(centres[fits][:, None] - xyz[some], axis=-1)
    best = int(np.minimum(np.abs(apart - radii[fits][:, None]) / near[some], 1.0).sum(axis=1).argmin())
    found = _refined_sphere(xyz, std, centres[fits][best], float(radii[fits][best]))
    return found if found is not None and abs(found.size - radius) < RADIUS_SLACK * radius else None


def _refined_sphere(xyz: Array, std: Array, centre: Array, radius: float) -> Primitive | None:
    """Gauss-Newton steps over the points that are near."""
    weight, near = _scales(std)
    off = np.linalg.norm(xyz - centre, axis=-1) - radius
    on = np.abs(off) < near
    for _ in range(2 * ROUNDS):
        if on.sum() < FEWEST:
            return None
        J, w = _towards(xyz[on], centre), weight[on]
        step = np.linalg.lstsq(np.sqrt(w)[:, None] * J, -np.sqrt(w) * off[on], rcond=None)[0]
        centre, radius = centre + step[:3], radius + float(step[3])
        off = np.linalg.norm(xyz - centre, axis=-1) - radius
        on = np.abs(off) < np.maximum(near, NEAR_STD * mad_scale(off[on]))
        if np.abs(step).max() < 1e-9:
            break
    if on.sum() < FEWEST:
        return None
    J, w = _towards(xyz[on], centre), weight[on]
    back = np.linalg.pinv(J.T @ (w[:, None] * J)) @ (w[:, None] * J).T
    return Primitive(centre, radius, float(np.sqrt((back[3] ** 2) @ off[on] ** 2)), on, off)


def _stands_out(distance: Array, on: Bools) -> bool:
    """Whether most points near a primitive are on it, by the distances of all candidates, (n,) [m]."""
    return bool(on.sum() > CLEAR * (np.abs(distance) < 3 * np.abs(distance[on]).max(initial=0.0)).sum())


def _towards(xyz: Array, centre: Array) -> Array:
    """Derivative of the distances from a sphere's surface by its centre and radius, (n, 4)."""
    ray = xyz - centre
    length = np.linalg.norm(ray, axis=-1, keepdims=True)
    return np.column_stack([-ray / np.where(length > 0, length, 1.0), -np.ones(len(xyz))])


def _through(fours: Array) -> tuple[Array, Array]:
    """Spheres through four points each, (k, 4, 3) -> centres (k, 3) and radii (k,); infinite for flat ones."""
    first = fours[:, :1]
    A = 2.0 * (fours[:, 1:] - first)
    b = (fours[:, 1:] ** 2).sum(axis=-1) - (first**2).sum(axis=-1)
    flat = np.abs(np.linalg.det(A)) < 1e-18
    A[flat] = np.eye(3)
    centres = np.linalg.solve(A, b[..., None])[..., 0]
    return centres, np.where(flat, np.inf, np.linalg.norm(centres - fours[:, 0], axis=-1))


def _scales(std: Array) -> tuple[Array, Array]:
    """Weight of each point, and largest distance from a primitive that it belongs to [m], (n,) each.

    Weights are limited by FLOOR, and equal where the scatter is not known.
    """
    known = np.isfinite(std).all() and (std > 0).any()
    weight = 1.0 / np.maximum(std, FLOOR * np.median(std)) ** 2 if known else np.ones(len(std))
    return weight, np.maximum(NEAR_STD * np.nan_to_num(std), LEAST_NEAR_M)
