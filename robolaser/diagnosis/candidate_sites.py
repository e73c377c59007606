"""Possible locations of a gap: derivatives of the residuals by smooth functions of any form at each site."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.path_velocities import known_velocities
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.gaussian_process_basis import smooth, smoothed
from robolaser.diagnosis.pose_coordinates import (
    LEAST_TORQUE_NM,
    angle_of,
    hanging,
    motion_of,
    of_run,
    overturning,
    torque_of,
)
from robolaser.diagnosis.stage_derivatives import StageDerivatives, stage_derivatives
from robolaser.diagnosis.thresholds import (
    CHI2_PER_PARAMETER,
    FINE,
    MAX_DISTORTION_PX,
    SEEN,
    SMOOTH,
    SMOOTH_LOAD,
)
from robolaser.estimation.noise_estimate import LEVER_M
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.joints import moving_joints
from robolaser.model.effects.link_geometry import LinkGeometry
from robolaser.model.effects.requirements import own_lengths, passes
from robolaser.model.effects.sensor_sites import sites_of_sensors
from robolaser.model.stages import Stage

Basis = tuple[str, Array]
"""Name of a coordinate of poses, and its basis functions, (n, p)."""
FORCE = "force at the flange"  # the coordinate of an external force at the flange
PER_LENGTH = 3  # least distinct values of a coordinate for each correlation length of waves: fewer may be chance
SLACK = 10  # most basis functions that locate something loose, which its weight moves from side to side
DENTS = 80  # most basis functions that locate dents in a target


@final
@dataclass(frozen=True, eq=False)
class Site:
    """A site, a coordinate, and the effect of smooth functions of that coordinate there."""

    # a joint's name, or one of `camera laser hand_eye target base timing image tool measuring_system`; with the
    # sensor's name before it where each of several sensors has its own: `left.laser`
    site: str
    coordinate: str  # its name in reports
    # derivatives of the whitened residuals by the moved quantities at their own poses, (K, q); for a function of
    # the row, by each basis function of each quantity
    moves: Array
    basis: Array  # the basis functions at each pose, (n, p); 1 for a function of the row
    of_number: Ints  # row of `basis` for each whitened number, (K,)
    unknown: bool = True  # whether the function may have a form outside the library of effects
    most: float = np.inf  # largest plausible standard deviation of the function, in its unit
    price: float = 0.0  # chi-squared for the choice of the direction of its moves

    @property
    def columns(self) -> Array:
        """Derivatives of the whitened residuals by each basis function of each moved quantity, (K, q p)."""
        products = self.moves[:, :, None] * self.basis[self.of_number][:, None]
        return np.asarray(products.reshape(len(products), -1))


@lru_cache(maxsize=2)
def sites(fit: Fit) -> tuple[Site, ...]:
    """Every site of the data set with each coordinate that a gap there may depend on; those of two fits are cached."""
    return tuple(_sites(fit))


def _sites(fit: Fit) -> Iterator[Site]:
    dataset = fit.model.dataset
    derivatives, run = stage_derivatives(fit), fit.model.run
    waved = [one for one in of_run(run) if FINE * len(np.unique(one.values)) >= PER_LENGTH]  # what sways has waves
    in_run = *smoothed(of_run(run)), *smoothed(waved, FINE)
    yield from _of_joints(fit, derivatives, in_run)
    yield from (site for site in of_several_joints(fit) if site.coordinate == FORCE)
    motion = np.r_[np.ones(3), np.full(3, 1.0 / LEVER_M)]
    middle, poses = dataset.flange()[:, :3, 3].mean(axis=0), fit.pose_of_number
    base = derivatives.base(middle) * motion
    for number, sensor in enumerate(dataset.members):  # a sensor may move alone: the others show that the arm did not
        if sensor.data.format.named_points == "tool":
            moved = derivatives.base(middle, dataset.sensor_of_row == number) * motion
            for coordinate, basis in in_run:
                yield Site(f"{sensor.name}.measuring_system", coordinate, moved, basis, poses)
    for coordinate, basis in (*in_run, *smoothed(overturning(run), SMOOTH_LOAD)):
        yield Site("base", coordinate, base, basis, poses)
    yield from of_leaning(fit)
    carried = derivatives.by_motion(Stage.FLANGE) * motion
    for coordinate, basis in in_run:
        shifted = Site("base", coordinate, base[:, :3], basis, poses)
        yield shifted
        if not fit.has_optics:  # with which an unknown motion excludes effects, though they drift along lines, too
            yield _along_one_line(fit, shifted)
            yield _along_one_line(fit, Site("tool", coordinate, carried[:, :3], basis, poses))
    loose = [(one.name, smooth(one.values, most=SLACK)) for one in hanging(run)]
    for coordinate, basis in (*in_run, *smoothed(hanging(run), SMOOTH_LOAD), *loose):
        yield Site("hand_eye" if fit.has_optics else "tool", coordinate, carried, basis, poses)
    yield from _of_camera_and_laser(fit, derivatives, in_run)
    yield from _of_target(fit, derivatives)
    yield from _of_measuring_system(fit, derivatives, in_run)


def _of_joints(fit: Fit, derivatives: StageDerivatives, in_run: Sequence[Basis]) -> Iterator[Site]:
    joints = moving_joints(fit.model.dataset.robot)
    if not joints:
        return
    (robot, q), run = fit.model.dataset.arm, fit.model.run
    free = {name: derivatives.by_motion(Stage.JOINTS, name) for name in joints}
    poses, constant = fit.pose_of_number, np.ones((len(fit.model.dataset.poses), 1))
    by_joint = {name: (angle_of(run, name), *torque_of(run, name)) for name in joints}
    turns_before = False
    for name in joints:
        own = tuple(smoothed(by_joint[name]))
        for coordinate, basis in (
            *own,
            *((one.name, one.values / np.abs(one.values).max()) for one in motion_of(run, name)),
            *in_run,
            ("posture", _of_posture(q)),
            *smoothed(one for other in joints if other != name for one in by_joint[other]),
        ):
            yield Site(name, coordinate, free[name], basis, poses)
        placement = derivatives.by_motion(Stage.LINKS, name) * np.r_[np.ones(3), np.full(3, 1.0 / LEVER_M)]
        if CandidateEffect(LinkGeometry, name) not in fit.effects:
            yield Site(name, f"placement of {name}", placement, constant, poses, unknown=False)
        across, shift = placement[:, 3:5], placement[:, :3]
        if not fit.has_optics:  # whose errors look alike
            (angle, by_angle), *_ = own
            yield from (Site(name, one, across, basis, poses) for one, basis in own)  # a bearing wobbles, a beam twists
            yield Site(name, angle, shift, by_angle, poses)  # a bearing runs out
        for coordinate, basis in in_run if turns_before else ():  # before any rotary joint it is a shift of the base
            yield Site(name, coordinate, shift, basis, poses)
        turns_before |= not robot.prismatic[robot.joints.index(name)]
    qd = known_velocities(fit.model.dataset)
    if qd is not None and np.abs(qd).max() > 0:
        late = np.sum([free[name] * qd[poses][:, [robot.joints.index(name)]] for name in joints], axis=0)
        yield Site("timing", "velocity", late, constant, poses)
        for coordinate, basis in in_run:
            yield Site("timing", coordinate, late, basis, poses)
        if (pixel := fit.model.dataset.points.pixel) is not None:  # a rolling shutter
            rows = fit.noise.correlate(late.T).reshape(1, len(pixel), -1)
            later = (pixel - pixel.mean(axis=0)).T[:, :, None] / np.ptp(pixel, axis=0).max()
            yield _of_rows("timing", "image position", fit.noise.whiten(rows * later).T)


def of_several_joints(fit: Fit) -> Iterator[Site]:
    """Sites of a single cause that turns several joints: a pull at the flange turns the last joints most.

    It is a function of the posture for each of these joints, all of one size; or a force that depends on the flange
    position, to which equally compliant joints yield. The middle one of these joints is the site.
    """
    dataset, poses, derivatives = fit.model.dataset, fit.pose_of_number, stage_derivatives(fit)
    joints = moving_joints(dataset.robot)[::-1]
    if not joints:
        return
    robot, q = dataset.arm
    last = [robot.joints.index(name) for name in joints]
    by_joint = np.hstack([derivatives.by_motion(Stage.JOINTS, name) for name in joints])
    posture = _of_posture(q)
    position = smooth(dataset.flange()[:, :3, 3], SMOOTH_LOAD)

    levers = robot.jacobian(q[None])[0, :, :3][poses][:, :, last]
    for several in range(len(last), 1, -1):
        middle, turns = joints[several // 2], by_joint[:, :several]
        yield Site(middle, "posture", turns, posture, poses)
        yield Site(middle, FORCE, (levers[:, :, :several] * turns[:, None]).sum(axis=2), position, poses)


def of_leaning(fit: Fit) -> Iterator[Site]:
    """Sites of a stand that tilts about the moment of the arm's weight, in any proportion or not alike to all sides."""
    base = stage_derivatives(fit).base(np.zeros(3))[:, 3:]
    for moment in overturning(fit.model.run):
        size = np.linalg.norm(moment.values, axis=1, keepdims=True)
        about = (moment.values / np.maximum(size, LEAST_TORQUE_NM))[fit.pose_of_number]
        tilted = np.einsum("kd,kd->k", base, about)[:, None]
        for basis in (smooth(size), smooth(moment.values)):
            yield Site("base", moment.name, tilted, basis, fit.pose_of_number)


def _along_one_line(fit: Fit, site: Site) -> Site:
    """A site that shifts along one line only: the one that the residuals follow most."""
    squares, V = np.linalg.eigh(site.moves.T @ site.moves)
    seen = squares > SEEN * squares[-1]
    apart = V[:, seen] / np.sqrt(squares[seen])
    pulls = (site.moves * fit.at.white[:, None]).T @ site.basis[site.of_number]
    line = apart @ np.linalg.svd(apart.T @ pulls)[0][:, :1]
    return replace(site, moves=site.moves @ line, price=CHI2_PER_PARAMETER * (np.count_nonzero(seen) - 1))


def _of_posture(q: Array) -> Array:
    """Basis of a function of all joint values (n, j), (n, p)."""
    return smooth(q, SMOOTH * np.sqrt(q.shape[1]))


def _of_camera_and_laser(fit: Fit, derivatives: StageDerivatives, in_run: Sequence[Basis]) -> Iterator[Site]:
    dataset = fit.model.dataset
    pixel = dataset.points.pixel
    if pixel is None or derivatives.passing(Stage.PIXELS) is None:
        return
    every = np.eye(2)
    for name, here in _rows_of_sensors(fit, "camera", Stage.PIXELS):
        moves = _over_rows(derivatives, Stage.PIXELS, every, smooth(pixel) * here[:, None])
        yield _of_rows(name, "image position", moves, most=MAX_DISTORTION_PX)
        yield from _of_focus(fit, derivatives, name, here, in_run)
    on_plane = derivatives.passing(Stage.POINTS)
    if on_plane is None:
        return
    tilt = fit.model.run.tilt
    distance = np.eye(4)[3:]
    motion = np.vstack([distance, np.eye(4)[2] / LEVER_M])  # a rotated plane shifts in proportion to the depth
    for name, here in _rows_of_sensors(fit, "laser", Stage.LASER_PLANE):
        directions = np.broadcast_to(fit.model.run.across_stripe, pixel.shape)
        across = int(directions[here][0].argmax())
        along = 1 - across
        for coordinate, basis in (
            ("position along the stripe", smooth(pixel[:, [along]])),
            ("position on the laser plane", _over_plane(on_plane[:, 1:])),
        ):
            moves = _over_rows(derivatives, Stage.LASER_PLANE, distance, basis * here[:, None])
            yield _of_rows(name, coordinate, moves)
        if np.ptp(tilt[here]) > 0:
            biased = _over_rows(derivatives, Stage.PIXELS, every[[across]], smooth(tilt[:, None]) * here[:, None])
            yield _of_rows(name, "tilt of the surface", biased)
        moved = _over_rows(derivatives, Stage.LASER_PLANE, motion, here[:, None].astype(np.float64))
        for coordinate, basis in in_run:
            middle = _centred(pixel[here, along], dataset.points.pose[here], len(basis))
            yield Site(name, coordinate, moved, np.concatenate([basis, basis * middle], axis=1), fit.pose_of_number)


def _of_focus(
    fit: Fit, derivatives: StageDerivatives, name: str, here: Bools, in_run: Sequence[Basis]
) -> Iterator[Site]:
    """A focal length that changes from image to image: with time, with recorded conditions, or with the distance.

    Its mean is a parameter of the camera, also where the data set holds it.
    """
    image = derivatives.passing(Stage.IMAGE)
    if image is None:
        return
    stretched = derivatives.of_rows(Stage.IMAGE, (image * here[:, None])[None])
    run, pose = fit.model.run, fit.model.dataset.points.pose[here]
    distance = _means(run.relative_range[here], pose, len(run.poses))[:, None]
    for coordinate, basis in (*in_run, ("distance", smooth(distance))):
        yield Site(name, coordinate, stretched, basis - basis.mean(axis=0), fit.pose_of_number)


def _rows_of_sensors(fit: Fit, site: str, stage: Stage) -> Iterator[tuple[str, Bools]]:
    """Names of a site, one for each sensor that has its own, each with the mask of its rows, (m,)."""
    dataset = fit.model.dataset
    parts = [sensor.data for sensor in dataset.sensors]
    for name, here in sites_of_sensors(site, dataset, lambda number: not passes(stage, parts[number])).items():
        yield name, here[dataset.sensor_of_row]


def _over_rows(derivatives: StageDerivatives, stage: Stage, directions: Array, basis: Array) -> Array:
    """Derivatives of the whitened residuals by functions (m, p) of the row, along directions (w, q), (K, w p)."""
    moves = directions[:, None, None] * basis.T[None, :, :, None]
    return derivatives.of_rows(stage, moves.reshape(-1, *moves.shape[2:]))


def _of_rows(site: str, coordinate: str, moves: Array, *, unknown: bool = True, most: float = np.inf) -> Site:
    """A site with a function of the row: shared noise mixes rows, so that its columns are whitened as a whole."""
    return Site(site, coordinate, moves, np.ones((1, 1)), np.zeros(len(moves), dtype=np.int64), unknown, most)


def _of_target(fit: Fit, derivatives: StageDerivatives) -> Iterator[Site]:
    points = fit.model.dataset.points
    if points.pixel is None or points.xyz is None or derivatives.passing(Stage.TARGET) is None:
        return
    every, upwards = np.eye(3), fit.model.run.target.axes[:, 2][None]
    for directions, basis in ((every, smooth(points.xyz)), (upwards, smooth(points.xyz, FINE, most=DENTS))):
        yield _of_rows("target", "position on the target", _over_rows(derivatives, Stage.TARGET, directions, basis))


def _of_measuring_system(fit: Fit, derivatives: StageDerivatives, in_run: Sequence[Basis]) -> Iterator[Site]:
    points = fit.model.dataset.points
    if points.xyz is None or own_lengths(fit.model.dataset):
        return
    longer = derivatives.of_rows(Stage.TARGET, points.xyz[None])
    yield _of_rows("measuring_system", "distance", longer, unknown=False)
    for coordinate, basis in in_run:
        yield Site("measuring_system", coordinate, longer, basis, fit.pose_of_number)
    range_m = np.linalg.norm(points.xyz, axis=1, keepdims=True)
    if fit.model.dataset.format.tracker:
        view = smooth(fit.model.run.view_in_flange)
        farther = view.T[:, :, None] * (points.xyz / range_m)
        yield _of_rows("measuring_system", "direction of view", derivatives.of_rows(Stage.TARGET, farther))
        names = dict.fromkeys(points.names)
        for number, name in enumerate(names if len(names) > 1 else ()):  # one may be off its centre
            own = farther * (points.number == number)[:, None]
            yield _of_rows("tool", f"direction of view of {name}", derivatives.of_rows(Stage.TARGET, own))
            slips = derivatives.of_body(Stage.FLANGE, points.number == number)[:, :3]
            for coordinate, basis in in_run:
                yield Site("tool", f"{coordinate}, at {name} alone", slips, basis, fit.pose_of_number)
    for coordinate, basis in (
        ("distance", smooth(range_m)),  # refraction in air
        ("position in space", points.xyz / max(float(np.ptp(points.xyz)), 1e-12)),  # strain
    ):
        yield _of_rows("measuring_system", coordinate, _over_rows(derivatives, Stage.TARGET, np.eye(3), basis))


def _over_plane(points: Array) -> Array:
    """Basis of a laser plane's errors at points (m, 2) on it: rotation, twist, curvature, and any smooth function."""
    across, deep = np.moveaxis((points - points.mean(axis=0)) / np.maximum(np.ptp(points, axis=0) / 2, 1e-9), -1, 0)
    return np.column_stack([across, across * deep, across**2, smooth(points)])


def _means(values: Array, pose: Ints, n: int) -> Array:
    """Mean of the rows' values in each pose, (n,); 0 in a pose without rows."""
    return np.asarray(np.bincount(pose, values, minlength=n) / np.maximum(np.bincount(pose, minlength=n), 1))


def _centred(values: Array, pose: Ints, n: int) -> Array:
    """Mean of the rows' values in each pose, scaled to ±1, (n, 1)."""
    mean = _means(values, pose, n)
    return np.asarray((2.0 * (mean - mean.min()) / max(float(np.ptp(mean)), 1e-12) - 1.0)[:, None])
