"""How a stripe's points move with whatever moves what passes the stages: eqs. 1-13 by the chain rule."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.camera import intersect, laser_plane, metric, rays, undistort
from robolaser.geometry.rigid_motion import carry, from_angles, from_quaternion, pose
from robolaser.model.sensors.placements import motion
from robolaser.model.stages import Stage
from robolaser.model.tangents import ChainRule, Tangent, carried
from robolaser.parameters import Values

IMAGE, PLANE = ("s_u", "s_v", "u_0", "v_0", "k"), ("b", "theta")
MOUNT = ("w", "phi", "psi", "t_x", "t_y", "t_z")


def stripe_slopes(dataset: Dataset, target: Sequence[str], flange: Tangent, chain: ChainRule) -> Array:
    """Derivatives of known less predicted points in the base frame, (c, q, m, 3).

    Args:
        dataset: Pixels, target points, and how the scanner is built.
        target: Parameters of T_base_target; none where the target is placed.
        flange: T_base_flange, (c or 1, n, 4, 4).
        chain: Passes values through the stages.
    """
    of_pose = dataset.points.pose
    seen = _in_camera(dataset, chain)
    mount = mount_of(dataset, chain)
    T_base_camera = flange.value @ mount.value
    turn = T_base_camera[:, of_pose if T_base_camera.shape[1] > 1 else np.zeros_like(of_pose), :3, :3]
    J = known_less_carried(dataset, target, flange, mount, chain, seen.value)
    J[:, seen.of] -= np.moveaxis(turn @ np.moveaxis(seen.slopes, 1, -1), -1, 1)
    return J


def known_less_carried(
    dataset: Dataset, target: Sequence[str], flange: Tangent, mount: Tangent, chain: ChainRule, points: Array
) -> Array:
    """How target points move in the base frame, less how flange and mount move points of the camera, (c, q, m, 3).

    Args:
        dataset: Target points.
        target: Parameters of T_base_target; none where the target is placed.
        flange: T_base_flange, (c or 1, n, 4, 4).
        mount: T_flange_camera, (c or 1, n or 1, 4, 4).
        chain: Passes values through the stages.
        points: One for each row, in the camera frame, (c, m, 3) [m].
    """
    of_pose, values = dataset.points.pose, chain.values
    known = chain(Stage.TARGET, Tangent.constant(dataset.points["xyz"][None]))
    J = np.zeros((len(values["f"]), chain.count, len(of_pose), 3))
    by_mount = Tangent(mount.value, flange.value[:, None] @ mount.slopes, mount.of)
    J[:, mount.of] -= carried(by_mount, of_pose, points)
    T_flange_camera = np.broadcast_to(mount.value, (len(mount.value), len(dataset.poses), 4, 4))
    J[:, flange.of] -= carried(flange, of_pose, carry(T_flange_camera, of_pose, points))
    if not target:
        J[:, known.of] += known.slopes
        return J
    T_base_target = motion(values, "target")
    J[:, known.of] += known.slopes @ np.swapaxes(T_base_target[:, None, :3, :3], -1, -2)
    placed = chain.through(
        lambda _, six: motion(six, "target")[:, None], target, Tangent.constant(np.eye(4)[None, None])
    )
    J[:, placed.of] += carried(placed, np.zeros_like(of_pose), known.value)
    return J


def mount_of(dataset: Dataset, chain: ChainRule) -> Tangent:
    """T_flange_camera, (c, n or 1, 4, 4). Eqs. 9-10."""
    bracket = from_quaternion(np.array(dataset.bracket_quat))

    def mounted(_: Array, values: Values) -> Array:
        turn = from_angles(values["w"], values["phi"], values["psi"], order=dataset.angles)
        return pose(bracket @ turn, np.stack([values["t_x"], values["t_y"], values["t_z"]], axis=-1))[:, None]

    return chain(Stage.MOUNT, chain.through(mounted, MOUNT, Tangent.constant(np.eye(4)[None, None])))


def _in_camera(dataset: Dataset, chain: ChainRule) -> Tangent:
    """Points on the laser plane that the pixels show, in the camera frame, (c, m, 3) [m]. Eqs. 1-6."""
    read = chain(Stage.PIXELS, Tangent.constant(dataset.points["pixel"][None]))
    image = chain(Stage.IMAGE, chain.through(lambda at, of: undistort(metric(at, of), of["k"]), IMAGE, read))
    ray = _rays(image, dataset.stripe_axis, chain)
    plane = chain.through(lambda _, of: laser_plane(of), PLANE, Tangent.constant(np.zeros((1, 1, 4))))
    plane = chain(Stage.LASER_PLANE, plane)
    point = intersect(ray.value, plane.value)
    facing = (ray.value * plane.value[..., :3]).sum(axis=-1)[:, None, :, None]
    depth = plane.value[:, None, :, 3:] / facing
    by_ray = ray.slopes * depth - point[:, None] * (
        (ray.slopes * plane.value[:, None, :, :3]).sum(axis=-1, keepdims=True) / facing
    )
    leaned = (plane.slopes[..., :3] * ray.value[:, None]).sum(axis=-1, keepdims=True)
    by_plane = (ray.value[:, None] * plane.slopes[..., 3:] - point[:, None] * leaned) / facing
    of = np.concatenate([ray.of, plane.of])
    both = np.concatenate([np.broadcast_to(part, (len(point), *part.shape[1:])) for part in (by_ray, by_plane)], axis=1)
    return chain(Stage.POINTS, Tangent(point, both, of))


def _rays(image: Tangent, stripe_axis: str, chain: ChainRule) -> Tangent:
    """Viewing rays, (c, m, 3) [m]; linear in the image coordinates and the focal length."""
    f, of_f = chain.values["f"], chain.columns(("f",))
    c, q = image.slopes.shape[:2]
    slopes = rays(image.slopes.reshape(-1, *image.slopes.shape[2:]), np.zeros(c * q), stripe_axis)
    slopes = slopes.reshape(c, q, *slopes.shape[1:])
    by_f = np.broadcast_to([0.0, 0.0, 1.0], (c, len(of_f), *slopes.shape[2:]))
    return Tangent(rays(image.value, f, stripe_axis), np.concatenate([slopes, by_f], axis=1), np.append(image.of, of_f))
