"""How good a cloud is: its scatter, and planes and spheres of known size: found by random samples, then fitted."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.errors import ScanError
from robolaser.geometry.mad_scale import mad_scale
from robolaser.scan.ply import Vertices, positions_of

STEP_SLACK = 0.5  # by which a step of known height may be off and still be taken for it
FAR_OFF = 3.0  # times that scatter and prediction may differ without a warning: few points alone make two
TINY = 1e-12  # metres: a prediction of zero is no divisor
LEVEL = 0.9  # share of points whose scatter is below what is reported beside the median
DRAWS = 600  # samples of points: with a fifth of them on the primitive, one is clean in 99 of 100 cases
JUDGES = 4000  # points by which samples are judged
NEAR_STD = 3.0  # scatters from a primitive within which a point may belong to it
LEAST_NEAR_M = 2e-4  # the same where points claim less: calibrations leave as much
ROUNDS = 10  # of fitting and leaving out
FEWEST = 30  # points that determine a primitive
FLOOR = 0.2  # of the median scatter: no point counts as if it had less
CLEAR = 0.75  # of the points within three times as far: a primitive has them, a cut through another one does not
RADIUS_SLACK = 0.3  # by which a sphere of known size may be off and still be taken for it


@final
@dataclass(frozen=True)
class Primitive:
    """A flat or a round part of a cloud."""

    # a plane's normal, of length one, the axis that it is nearest to positive; a sphere's centre [m], (3,)
    place: Array
    size: float  # the plane's offset along its normal: normal · P = offset; the sphere's radius [m]
    size_std: float  # standard deviation, of points whose errors are independent [m]
    on: Bools  # the points that lie on it, (n,)
    distance: Array  # of all points from it, (n,) [m]

    @property
    def rms_m(self) -> float:
        """Scatter of its points about it."""
        return float(np.sqrt(np.mean(self.distance[self.on] ** 2)))


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


def _find_plane(xyz: Array, std: Array, rng: np.random.Generator, normal: Array | None = None) -> Primitive | None:
    """The plane with the most points (n, 3), across a normal (3,) where one is given; None where too few lie on it."""
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
    """The sphere of about a known radius [m] with the most points (n, 3); None where fewer than FEWEST lie on one."""
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
    """Whether most points about a primitive are on it, by the distances of all that might have been, (n,) [m]."""
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
    radii = np.linalg.norm(centres - fours[:, 0], axis=-1)
    return centres, np.where(flat, np.inf, radii)


def _scales(std: Array) -> tuple[Array, Array]:
    """How much each point counts, and how far from a primitive it may be and still belong to it [m], (n,) each.

    None counts much more than the others; all are alike where their scatter is not known.
    """
    known = np.isfinite(std).all() and (std > 0).any()
    weight = 1.0 / np.maximum(std, FLOOR * np.median(std)) ** 2 if known else np.ones(len(std))
    return weight, np.maximum(NEAR_STD * np.nan_to_num(std), LEAST_NEAR_M)
