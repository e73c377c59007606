"""What shakes a residual: pixels, target points, joint readings and flange poses, each by one standard deviation.

The residuals e (m, 3) of a model are e = e₀ + Σ σ_k A_k ξ_k with independent standard normal ξ. Here are the A_k.
Poses are independent of each other; what shakes a pose as a whole shakes all its rows together.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Poses
from robolaser.geometry.rigid_motion import skew
from robolaser.model.forward_model import Model
from robolaser.model.noise.whitening import group_sums
from robolaser.model.sensors.sensor import motion
from robolaser.model.sensors.stripe import Stripe
from robolaser.parameters import Values

PIXEL_STEP_PX = 0.25  # far above rounding, far below the lens's curvature
JOINT_STEP = 1e-5  # [rad or m]


@final
@dataclass(frozen=True)
class Disturbance:
    """One source of error and what a unit of it does to each row.

    Attributes:
        name: One of `pixel target point seat joint probe probe_turn flange flange_turn`.
        effect: Move of each row's residual by each of q independent unit errors, (m, 3, q) [m per unit].
        group: Rows with one number share their q errors, (m,); a group never reaches beyond one pose.
    """

    name: str
    effect: Array
    group: Ints

    @property
    def isotropic(self) -> bool:
        """Whether a unit error moves every row by a unit along each axis."""
        return self.effect.strides[0] == 0 and np.array_equal(self.effect[0], np.eye(3))


def disturbances(model: Model, x: Array) -> tuple[Disturbance, ...]:
    """All that may shake a model's residuals at x (d,).

    - stripe: `pixel` [px], each row's own; `target` [m], isotropic, shared by the repeats of a point.
    - tracker: `point` [m], isotropic, each row's own. Sockets: `seat` [m], likewise.
    - `joint` [rad], where joint angles were read: an independent error on each reading, carried through the chain,
      shared by the pose's rows. A linear axis counts in metres with the same number: at arm's length alike.
    - `probe` [m] and `probe_turn` [rad], shared by the pose's rows, where a tracker sees several points a pose, which
      may come from one measurement of six dimensions.
    - `flange` [m] and `flange_turn` [rad], likewise, where flange poses were measured, and for a stripe scanner where
      `joint_rad` is stated.

    Turns are about the middle of the pose's points: then shift and turn are told apart by what they do there, and
    neither grows to cancel the other over the arm between flange and points.

    So at the level of the pose there is always a source that nobody stated, for which the residuals may speak.
    """
    values = model.parameters.values(x[None])
    dataset = model.dataset
    rows = np.arange(len(dataset.points))
    every = np.broadcast_to(np.eye(3), (len(rows), 3, 3))
    found: list[Disturbance] = []
    if isinstance(model.sensor, Stripe):
        found.append(Disturbance("pixel", pixel_effect(model, model.sensor, values), rows))
        found.append(Disturbance("target", every, dataset.points.place))
    else:
        found.append(Disturbance("point" if dataset.kind == "point" else "seat", every, rows))
    of_pose, stated = dataset.points.pose, dataset.noise
    has_joints = dataset.robot is not None and dataset.poses.q is not None
    if has_joints:
        found.append(Disturbance("joint", _joint_effect(model, values), of_pose))
    shared = np.bincount(of_pose).max() > 1  # else an error of the pose would be one of its row under another name
    if dataset.kind == "point" and has_joints:
        whole = "probe"
        wanted = shared or stated.point_m is not None
    else:
        whole = "flange"
        wanted = shared and (not has_joints or stated.joint_rad is not None)
    if wanted:
        found.append(Disturbance(whole, every, of_pose))
    if wanted and shared:
        found.append(Disturbance(f"{whole}_turn", skew(arms(model, values)), of_pose))
    return tuple(found)


def pixel_effect(model: Model, sensor: Stripe, values: Values) -> Array:
    """Move of each residual with its own pixel's u and v, (m, 3, 2) [m/px].

    Where points come from images of a board, the known place of a row is its very pixel carried to the board by the
    homography, so it moves with the noise too. For all pixels both stay on one viewing ray o + λ r, the known place
    where the ray meets the board (λ_b), the predicted one where it meets the sheet (λ_s): the residual is
    (λ_b − λ_s) r, and near the optimum, where λ_b ≈ λ_s, its derivative is r (∂λ_b − ∂λ_s). The board is z = 0 of
    the target's frame where the parameters place it, else the plane through all target points.
    """
    perturb = model.perturb(values)
    T_base_flange = model.flange(values, perturb)
    pixel = model.dataset.points.pixel
    assert pixel is not None  # the sensor sees to it

    def slopes(of_pixel: Callable[[Array], Array]) -> Iterator[Array]:
        for shift in PIXEL_STEP_PX * np.eye(2):
            yield (of_pixel(pixel[None] + shift) - of_pixel(pixel[None] - shift)) / (2 * PIXEL_STEP_PX)

    def predicted(at: Array) -> Array:
        seen: Array = sensor.in_base(values, T_base_flange, perturb, pixel=at)[0]
        return seen

    if model.dataset.board is None:
        moved: Array = -np.stack(list(slopes(predicted)), axis=-1)
        return moved

    centre = (T_base_flange @ sensor.mount(values, perturb))[0, :, :3, 3]
    centre = np.broadcast_to(centre, (len(model.dataset.poses), 3))[model.dataset.points.pose]
    if model.dataset.placed:
        known = sensor.target(values, perturb)[0]
        origin, normal = known.mean(axis=0), np.linalg.svd(known - known.mean(axis=0), full_matrices=False)[2][2]
    else:
        T_base_target = motion(values, "target")[0]
        origin, normal = T_base_target[:3, 3], T_base_target[:3, 2]

    def ray(at: Array) -> tuple[Array, Array]:
        seen = predicted(at) - centre
        length = np.linalg.norm(seen, axis=-1, keepdims=True)
        return seen / length, length

    def gap(at: Array) -> Array:
        direction, to_sheet = ray(at)
        to_board: Array = ((origin - centre) @ normal)[:, None] / (direction @ normal)[:, None]
        return to_board - to_sheet

    along: Array = ray(pixel[None])[0][:, :, None] * np.stack(list(slopes(gap)), axis=-1)
    return along


def _joint_effect(model: Model, values: Values) -> Array:
    robot, poses, perturb = model.dataset.robot, model.dataset.poses, model.perturb(values)
    assert robot is not None
    assert poses.q is not None

    def residuals(poses: Poses) -> Array:
        shaken = Model(replace(model.dataset, poses=poses), model.effects)
        e: Array = model.sensor.residuals(values, shaken.flange(values), perturb)[0]
        return e

    slopes: list[Array] = []
    for shift in JOINT_STEP * np.eye(len(robot.joints))[list(robot.chain)]:
        up, down = (residuals(replace(poses, q=poses.q + way * shift)) for way in (1, -1))
        slopes.append((up - down) / (2 * JOINT_STEP))
    return np.stack(slopes, axis=-1)


def arms(model: Model, values: Values) -> Array:
    """Give the way from the middle of each pose's points to each point, (m, 3) [m]."""
    of_pose = model.dataset.points.pose
    if isinstance(model.sensor, Stripe):
        points: Array = model.sensor.target(values, model.perturb(values))[0]
    else:
        assert model.dataset.points.xyz is not None  # sockets have one row a pose, and nothing turns
        points = model.dataset.points.xyz
    middle: Array = group_sums(points, of_pose) / np.bincount(of_pose).clip(min=1)[:, None]
    return points - middle[of_pose]
