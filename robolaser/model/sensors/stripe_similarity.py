"""Baseline, hand-eye and target of a stripe scanner from its camera and laser plane: a similarity, then clipped."""

from collections.abc import Mapping

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import apply, carry, from_angles, from_quaternion, inverse, nearest_rotation
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.scanner_start import target_by_stripe
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Parameter, Values

SIMILARITY = ("b", "w", "phi", "psi", "t_x", "t_y", "t_z")
ALTERNATIONS = 5  # fits of the hand-eye and of an unplaced target in turn, from the linear solution


def solve_similarity(
    dataset: Dataset, values: Values, T_base_flange: Array, perturb: Perturbation, bounds: Mapping[str, Parameter]
) -> Values:
    """The other parameters, within their bounds: points grow with the baseline, exactly where the plane is flat.

    Args:
        dataset: What the scanner saw.
        values: All parameters, (c,) each; the baseline among them is the one at which points are taken.
        T_base_flange: (c or 1, n, 4, 4).
        perturb: The effects; those at the mount are taken as if the camera's frame were the flange's.
        bounds: All parameters by name.

    Returns:
        `SIMILARITY`, and `target.*` of an unplaced target, (c,) each; unchanged for candidates at a pole.
    """
    pose = dataset.points.pose
    moved = perturb(Stage.MOUNT, np.eye(4)[None, None])
    moved = np.broadcast_to(moved, (len(moved), len(dataset.poses), 4, 4))
    seen = scanner_geometry.in_camera(dataset.points["pixel"][None], values, perturb, dataset.stripe_axis)
    good = np.asarray(np.isfinite(seen).all(axis=(1, 2)) & np.isfinite(T_base_flange).all(axis=(1, 2, 3)))
    seen = carry(moved, pose, np.where(good[:, None, None], seen, 0.0))
    T = T_base_flange[:, pose]
    if dataset.placed:
        known = apply(inverse(T), scanner_geometry.target(dataset, values, perturb))
        found = dict(zip(SIMILARITY, _mounted(dataset, values, seen, known, bounds), strict=True))
    else:
        known = _of_loop(seen, perturb(Stage.TARGET, dataset.points["xyz"][None]), T)
        found = {}
        for _ in range(ALTERNATIONS):
            found = dict(zip(SIMILARITY, _mounted(dataset, values, seen, known, bounds), strict=True))
            found |= target_by_stripe(dataset, {**values, **found}, T_base_flange, perturb)
            known = apply(inverse(T), scanner_geometry.target(dataset, {**values, **found}, perturb))
    return {
        name: np.where(good, np.clip(_unwound(value, item := bounds[name]), item.lower, item.upper), values[name])
        for name, value in found.items()
    }


def _mounted(
    dataset: Dataset, values: Values, seen: Array, known: Array, parameters: Mapping[str, Parameter]
) -> tuple[Array, ...]:
    """`SIMILARITY` that brings seen points (c, m, 3) in the camera frame nearest to known ones on the flange.

    Points on a plane fit equally well with minus the baseline and half a turn: the better one if the bounds allow both.
    """
    bounds = [parameters[name] for name in SIMILARITY]
    reach = np.sort([bound / values["b"] for bound in (bounds[0].lower, bounds[0].upper)], axis=0)
    bracket, order = from_quaternion(np.array(dataset.bracket_quat)), dataset.angles
    best, least = np.zeros((len(SIMILARITY), len(seen))), np.full(len(seen), np.inf)
    for sign in (1.0, -1.0) if reach[0].min() < 0.0 else (1.0,):
        R, scale = _similarity(seen, known, reach, sign)
        angles = _angles_within(bracket.T @ R, order, bounds[1:4])
        angles = [np.clip(angle, item.lower, item.upper) for angle, item in zip(angles, bounds[1:4], strict=True)]
        turned = scale[:, None, None] * (seen @ np.swapaxes(bracket @ from_angles(*angles, order=order), 1, 2))
        t = (known - turned).mean(axis=1)
        left = np.square(known - turned - t[:, None]).sum(axis=(1, 2))
        best = np.where(left < least, np.stack([values["b"] * scale, *angles, *t.T]), best)
        least = np.minimum(left, least)
    return tuple(best)


def _similarity(seen: Array, known: Array, reach: Array, sign: float) -> tuple[Array, Array]:
    """Rotations (c, 3, 3) and scales (c,) of that sign, within their reach (2, c). Umeyama 1991."""
    centred = seen - seen.mean(axis=1, keepdims=True)
    H = np.swapaxes(known - known.mean(axis=1, keepdims=True), 1, 2) @ centred
    R, s = nearest_rotation(sign * H)
    size = np.maximum(np.square(centred).sum(axis=(1, 2)), np.finfo(np.float64).tiny)
    return R, np.clip(sign * s.sum(axis=-1) / size, *reach)


def _angles_within(R: Array, order: str, bounds: list[Parameter]) -> list[Array]:
    """Three angles of rotations (c, 3, 3), of their two sets the one nearer to the bounds, less whole turns."""
    if order == "xyz":
        phi = np.arcsin(np.clip(R[:, 0, 2], -1.0, 1.0))
        first = [np.arctan2(-R[:, 1, 2], R[:, 2, 2]), phi, np.arctan2(-R[:, 0, 1], R[:, 0, 0])]
        second = [first[0] + np.pi, np.pi - phi, first[2] + np.pi]
    else:
        phi = np.arccos(np.clip(R[:, 2, 2], -1.0, 1.0))
        first = [np.arctan2(R[:, 1, 2], R[:, 0, 2]), phi, np.arctan2(R[:, 2, 1], -R[:, 2, 0])]
        second = [first[0] + np.pi, -phi, first[2] + np.pi]
    midpoints = [(item.lower + item.upper) / 2.0 for item in bounds]
    sets = [[_unwound(angle, item) for angle, item in zip(some, bounds, strict=True)] for some in (first, second)]
    beyond = [
        sum(np.maximum(np.abs(angle - midpoint) - (item.upper - item.lower) / 2.0, 0.0)
            for angle, midpoint, item in zip(some, midpoints, bounds, strict=True))
        for some in sets
    ]  # fmt: skip
    return [np.where(beyond[0] <= beyond[1], one, other) for one, other in zip(*sets, strict=True)]


def _unwound(value: Array, item: Parameter) -> Array:
    """An angle (c,) less the whole turns away from its bounds; a length unchanged."""
    if item.unit != "rad":
        return value
    middle = (item.lower + item.upper) / 2.0
    return np.asarray((value - middle + np.pi) % (2.0 * np.pi) - np.pi + middle)


def _of_loop(seen: Array, target: Array, T_base_flange: Array) -> Array:
    """An unplaced target's points in the flange frame, by the linear solution of AX = ZB, (c, m, 3) [m].

    R_f (M p + t) + t_f = N q + n for every row, linear in M, t, N and n. Points on a plane do not determine M, but
    they do determine M p.

    Args:
        seen: p in the camera frame, (c, m, 3).
        target: q in the target's frame, (c or 1, m, 3).
        T_base_flange: Of each row, (c or 1, m, 4, 4).
    """
    c, m, _ = seen.shape
    target, T = np.broadcast_to(target, seen.shape), np.broadcast_to(T_base_flange, (c, m, 4, 4))
    R, ones = T[..., :3, :3], np.ones((c, m, 1))
    of_mount = np.einsum("cmij,cmk->cmijk", R, np.concatenate([seen, ones], axis=-1)).reshape(c, m, 3, 12)
    of_target = np.einsum("ij,cmk->cmijk", -np.eye(3), np.concatenate([target, ones], axis=-1)).reshape(c, m, 3, 12)
    rows = np.concatenate([of_mount, of_target], axis=-1).reshape(c, 3 * m, 24)
    right = -np.swapaxes(rows, 1, 2) @ T[..., :3, 3].reshape(c, 3 * m, 1)
    found = np.linalg.pinv(np.swapaxes(rows, 1, 2) @ rows, rcond=1e-12, hermitian=True) @ right
    M = found[:, :12, 0].reshape(c, 3, 4)
    return np.asarray(seen @ np.swapaxes(M[..., :3], 1, 2) + M[:, None, :, 3])
