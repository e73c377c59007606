"""Placements and points as named parameters: `target.x` .. `target.psi`, `tool.P.x` .. `tool.P.z`."""

from collections.abc import Iterable, Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import from_angles, pose, to_angles
from robolaser.parameters import Values, from_batch

SIX = ("x", "y", "z", "w", "phi", "psi")


def six_names(prefix: str) -> tuple[str, ...]:
    """The names of the six parameters of a rigid motion."""
    return tuple(f"{prefix}.{part}" for part in SIX)


def motion(values: Values, prefix: str) -> Array:
    """The rigid motion of six parameters `prefix.x` .. `prefix.psi`, (c, 4, 4)."""
    x, y, z, w, phi, psi = (values[f"{prefix}.{part}"] for part in SIX)
    return pose(from_angles(w, phi, psi), np.stack([x, y, z], axis=-1))


def six_of(T: Array, prefix: str) -> dict[str, Array]:
    """The six parameters of a rigid motion (c, 4, 4), by name."""
    parts = (*np.moveaxis(T[:, :3, 3], -1, 0), *to_angles(T[:, :3, :3]))
    return {f"{prefix}.{part}": value for part, value in zip(SIX, parts, strict=True)}


def numbers_of_motion(T: Array, prefix: str) -> dict[str, float]:
    """The six numbers of one rigid motion, (4, 4), by name."""
    return from_batch(six_of(T[None], prefix))


def named_parts(prefix: str, numbers: Iterable[float]) -> dict[str, float]:
    """A point's three numbers, or the six of a rigid motion, by name."""
    return {f"{prefix}.{part}": float(number) for part, number in zip(SIX, numbers, strict=False)}


def vector(values: Values, prefix: str) -> Array:
    """The point of three parameters `prefix.x` .. `prefix.z`, (c, 3)."""
    return np.stack([values[f"{prefix}.{part}"] for part in "xyz"], axis=-1)


def places(values: Values, thing: str, names: Sequence[str]) -> Array:
    """The points of parameters `thing.NAME.x` .. `thing.NAME.z`, (c, names, 3)."""
    return np.stack([vector(values, f"{thing}.{name}") for name in names], axis=1)


def places_by_name(points: Array, thing: str, names: Sequence[str]) -> dict[str, Array]:
    """The parameters of points (c, names, 3), by name."""
    each = points.reshape(len(points), -1).T
    return dict(zip((f"{thing}.{name}.{part}" for name in names for part in "xyz"), each, strict=True))
