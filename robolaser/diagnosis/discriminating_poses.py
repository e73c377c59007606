"""Poses at which two rival explanations disagree the most: measure these next."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.diagnosis.fit import Fit
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.geometry.visibility import View, limits, random_configurations
from robolaser.model.sensors.sensor import motion
from robolaser.model.sensors.stripe import Stripe
from robolaser.model.stages import Perturbation

TRIED = 1500
"""Postures that are tried: half near measured ones, half random."""
NEAR_RAD = 0.4
"""How far from a measured one, as a standard deviation of each joint [rad or m]."""
WANTED = 5
APART_RAD = 0.3
"""Distance in joint space that postures keep from one another [rad or m]."""
ALONG = 5
"""Points along the stripe at which the rivals are compared."""


def next_poses(one: Fit, other: Fit, *, seed: int) -> tuple[Mapping[str, float], ...]:
    """Postures within the joint limits, the target in sight, that would tell two fitted models apart best.

    Both models, each with its own best parameters, predict what would be measured; where they differ most, in
    standard deviations of the noise, a measurement decides most (T-optimality: Atkinson, Fedorov 1975).

    Returns:
        Joint values by name [rad or m], the most telling first; none where the sensor cannot go anywhere (sockets) or
        no joint angles were read.
    """
    dataset = one.model.dataset
    robot, q = dataset.robot, dataset.poses.q
    if robot is None or q is None or dataset.points.xyz is None:
        return ()
    rng = np.random.default_rng(seed)
    lower, upper = limits(robot)
    seen = q[np.unique(dataset.points.pose)]
    near = seen[rng.integers(len(seen), size=TRIED)] + NEAR_RAD * rng.standard_normal((TRIED, q.shape[1]))
    tried = np.concatenate([near[: TRIED // 2], random_configurations(robot, TRIED - TRIED // 2, rng)])
    still = np.ptp(q, axis=0) == 0
    tried[:, still] = q[0, still]
    tried = tried[((tried >= lower) & (tried <= upper) | still).all(axis=1)]
    extended, rows, tried = _with(dataset, tried, one)
    if not len(tried):
        return ()
    apart = _prediction(one, extended)[rows] - _prediction(other, extended)[rows]
    root = np.linalg.inv(np.linalg.cholesky(one.noise.covariances.mean(axis=0)))
    told = np.nan_to_num(((apart @ root.T) ** 2).sum(axis=(1, 2)))
    chosen: list[int] = []
    for i in np.argsort(-told, kind="stable"):
        if all(np.linalg.norm(tried[i] - tried[j]) >= APART_RAD for j in chosen):
            chosen.append(int(i))
        if len(chosen) == WANTED:
            break
    return tuple(dict(zip(robot.joints, tried[i].tolist(), strict=True)) for i in chosen)


def _prediction(fitted: Fit, extended: Dataset) -> Array:
    """Residuals of all rows of a longer data set by a model's parameters, (m, 3) [m]."""
    problem = fitted.problem
    model = replace(problem.model, dataset=extended)
    e: Array = model.residuals_at(problem.parameters.values(fitted.x[None]))[0]
    return e


def _with(dataset: Dataset, q: Array, fitted: Fit) -> tuple[Dataset, Ints, Array]:
    """The data set with postures (k, j) after its last pose; rows of each, (k', r); and those that see the target."""
    points = dataset.points
    if dataset.points.pixel is not None:
        pixel, xyz, good = _stripes(dataset, q, fitted)
        q, pixel, xyz = q[good], pixel[good], xyz[good]
        names = tuple(str(i) for i in range(pixel.shape[1])) * len(q)
        flat_pixel, flat_xyz = pixel.reshape(-1, 2), xyz.reshape(-1, 3)
    else:
        each = tuple(dict.fromkeys(points.names))
        names, flat_pixel, flat_xyz = each * len(q), None, np.zeros((len(each) * len(q), 3))
    n, r = len(dataset.poses), len(names) // max(1, len(q))
    of_pose = np.concatenate([points.pose, n + np.repeat(np.arange(len(q)), r)])
    longer = Points(
        of_pose,
        (*points.names, *names),
        pixel=None if points.pixel is None or flat_pixel is None else np.concatenate([points.pixel, flat_pixel]),
        xyz=None if points.xyz is None else np.concatenate([points.xyz, flat_xyz]),
    )
    rows = len(points) + np.arange(len(q) * r).reshape(len(q), r)
    return replace(dataset, poses=_after(dataset.poses, q), points=longer), rows, q


def _after(poses: Poses, q: Array) -> Poses:
    """Poses with more at the end, all at the time of the last, at rest, in its warmth."""
    assert poses.q is not None
    last = 0 if poses.time_s is None else int(np.argmax(poses.time_s))
    k = len(q)
    return Poses(
        names=(*poses.names, *(f"next {i}" for i in range(k))),
        time_s=None if poses.time_s is None else np.concatenate([poses.time_s, np.full(k, poses.time_s[last])]),
        q=np.concatenate([poses.q, q]),
        qd=None if poses.qd is None else np.concatenate([poses.qd, np.repeat(poses.qd[[last]], k, axis=0)]),
        payload_kg=_as_last(poses.payload_kg, last, k),
        temperature_c=_as_last(poses.temperature_c, last, k),
        extra={name: (*cells, *(cells[last],) * k) for name, cells in poses.extra.items()},
    )


def _as_last(values: Array | None, last: int, k: int) -> Array | None:
    return None if values is None else np.append(values, np.full(k, values[last]))


def _stripes(dataset: Dataset, q: Array, fitted: Fit) -> tuple[Array, Array, Bools]:
    """Where the stripe on the target's middle level would show, (k, r, 2) [px], the points there, and which see it."""
    values = fitted.problem.parameters.values(fitted.x[None])
    sensor = fitted.model.sensor
    assert isinstance(sensor, Stripe)  # nothing else has stripes
    T_flange_camera = sensor.mount(values, Perturbation())[0, 0]
    assert dataset.robot is not None
    assert dataset.points.xyz is not None
    width, height = dataset.image_px or (640, 480)
    view = View(T_flange_camera, {k: float(v[0]) for k, v in values.items()}, dataset.stripe_axis, (width, height))
    T_base_camera = dataset.robot.forward(q[None])[0] @ T_flange_camera
    T_base_target = np.eye(4) if dataset.placed else motion(values, "target")[0]
    T_target_camera = inverse(T_base_target) @ T_base_camera
    level = float(np.median(dataset.points.xyz[:, 2]))
    seen = view.illuminated(T_target_camera, level, np.linspace(*view.stripe_range(), ALONG)[None])
    pixel, shown = view.pixels(seen), apply(T_target_camera[:, None], seen)
    low, high = dataset.points.xyz.min(axis=0), dataset.points.xyz.max(axis=0)
    on = ((shown >= low) & (shown <= high))[..., :2].all(axis=(1, 2))
    inside = view.contains(pixel.reshape(-1, 2)).reshape(len(q), -1).all(axis=1)
    return pixel, shown, np.asarray(on & inside)
