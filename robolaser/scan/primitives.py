"""Planes and spheres in clouds: found by random samples, then fitted with each point's own scatter."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.geometry.mad_scale import mad_scale

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


def find_plane(xyz: Array, std: Array, rng: np.random.Generator, normal: Array | None = None) -> Primitive | None:
    """The plane with the most points; None where fewer than FEWEST lie on one.

    Args:
        xyz: (n, 3) [m].
        std: Scatter of each, (n,) [m]; NaN where it is not known.
        rng: Draws the samples.
        normal: Look only for planes across this direction, (3,).
    """
    if len(xyz) < FEWEST:
        return None
    near = _near(std)
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
    weight, near = _weights(std), _near(std)
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


def find_sphere(xyz: Array, std: Array, radius: float, rng: np.random.Generator) -> Primitive | None:
    """The sphere of about a known radius with the most points; None where fewer than FEWEST lie on one.

    Args:
        xyz: (n, 3) [m].
        std: Scatter of each, (n,) [m]; NaN where it is not known.
        radius: About its own [m]; one that is off by more than RADIUS_SLACK is another sphere.
        rng: Draws the samples.
    """
    if len(xyz) < FEWEST:
        return None
    from scipy.spatial import cKDTree  # noqa: PLC0415 - loaded when needed: scipy is slow to import

    near = _near(std)
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
    weight, near = _weights(std), _near(std)
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


def stands_out(distance: Array, on: Bools) -> bool:
    """Whether most of the points about a primitive are on it.

    Args:
        distance: From the primitive, of all points that might have been on it, (n,) [m].
        on: Those that are, (n,).
    """
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


def _near(std: Array) -> Array:
    return np.asarray(np.maximum(NEAR_STD * np.nan_to_num(std), LEAST_NEAR_M))


def _weights(std: Array) -> Array:
    """By the points' scatter, none of them much above the others; all alike where it is not known."""
    if not np.isfinite(std).all() or not (std > 0).any():
        return np.ones(len(std))
    return np.asarray(1.0 / np.maximum(std, FLOOR * np.median(std)) ** 2)
