"""Blind worlds, also random ones: an arm over a stepped target, a scanner with errors, a run of configurations."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.stated_noise import Noise
from robolaser.errors import TrialError
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import farthest_first, limits
from robolaser.robot.visibility import TILT, View, configurations_looking_down
from robolaser.simulation.nominal import built, facing_outward, scanner
from robolaser.trials.synthetic.cell import ScannerCell, Target, TrackerCell
from robolaser.trials.synthetic.fault_model import FaultModel, SyntheticRun
from robolaser.trials.synthetic.fault_models.joints import PoseScatter
from robolaser.trials.synthetic.scanner import ScannerOptics


@final
@dataclass(frozen=True)
class World:
    """A cell with all its imperfections other than faults."""

    cell: ScannerCell | TrackerCell  # the true cell
    blank: Dataset  # the data set without points
    noise: Noise  # of the readings, stated or not
    repeats: int = 1  # images at each pose
    scatter: PoseScatter | None = None  # the arm's repeatability; None: perfect
    image_px: float = 0.0  # common error of an image, one standard deviation [px]
    growth: float = 0.0  # power of the range with which the noise of a pixel, or of a tracker's point, grows
    background: tuple[FaultModel, ...] = ()  # small errors in addition to the faults

    def exact(self, faults: Sequence[FaultModel]) -> Dataset:
        """The data set with one row a point, without noise."""
        return replace(self.blank, points=self.cell.seen(faults))

    def read(self, faults: Sequence[FaultModel], rng: np.random.Generator) -> Dataset:
        """The data set with all shots, scatter, small errors, noise and gross errors."""
        scatter = [] if self.scatter is None else [self.scatter]
        points = self.cell.seen([*scatter, *self.background, *faults])
        noise, m = self.noise, len(points)
        farther = self.cell.ranges(points) ** self.growth
        farther = farther[:, None] / np.sqrt(np.nanmean(np.square(farther)))  # its mean square is one
        if points.pixel is None:
            xyz = points["xyz"] + (noise.point_m or 0.0) * farther * rng.normal(size=(m, 3))
            return replace(self.blank, points=replace(points, xyz=xyz))
        xyz = points["xyz"] + (noise.target_m or 0.0) * rng.normal(size=(m, 3))
        shot, repeat = np.repeat(np.arange(m), self.repeats), np.tile(np.arange(self.repeats), m)
        shots = replace(points, xyz=xyz).take(shot)
        pixel = shots["pixel"] + (noise.pixel_px or 0.0) * farther[shot] * rng.normal(size=(len(shot), 2))
        if self.image_px:
            of_image = self.image_px * rng.normal(size=(len(self.cell.run.q), self.repeats, 2))
            pixel = pixel + of_image[shots.pose, repeat]
        for fault in faults:
            pixel = fault.shots(pixel, shot, rng)
        assert self.blank.image_px is not None  # the data set is a scanner's
        with np.errstate(invalid="ignore"):
            in_image = ((pixel >= -0.5) & (pixel <= np.array(self.blank.image_px) - 0.5)).all(axis=1)
        return replace(self.blank, points=replace(shots, pixel=pixel, repeat=repeat).take(in_image))

    def sigmas(self, *, of_row: bool) -> dict[str, float]:
        """Standard deviations of the sources of noise, repeats averaged.

        `of_row` counts a common error of an image as one of its rows' mean.
        """
        shared = self.image_px
        if shared and of_row:
            shared *= float(np.sqrt(np.bincount(self.cell.seen(()).pose).max()))
        return {
            "pixel": float(np.hypot(self.noise.pixel_px or 0.0, shared) / np.sqrt(self.repeats)),
            "target": self.noise.target_m or 0.0,
            "point": self.noise.point_m or 0.0,
            "joint": 0.0 if self.scatter is None else self.scatter.sigma(self.cell.run),
        }


IMAGE_PX = (640, 480)
WORKSHOP = {  # largest deviations of a scanner from nominal, SI
    "f": 1.5e-4, "s_u": 5e-8, "s_v": 5e-8, "u_0": 5.0, "v_0": 5.0, "k": 800.0, "b": 2e-3, "theta": 0.02,
    "w": 0.02, "phi": 0.02, "psi": 0.02, "t_x": 2e-3, "t_y": 2e-3, "t_z": 2e-3,
}  # fmt: skip
LEVELS_M = np.array([0.0, 0.03, 0.06])
PAUSE_S = (50.0, 70.0)
SPEED = 0.6  # at the exposure of a moving arm [rad/s or m/s]
AROUND = 0.5  # range around one posture, for runs near it [rad or m]
DRAWS = 20_000
ROUNDS = 6
PAYLOAD_KG = (0.2, 0.8)  # scanner and bracket, which are in no URDF
MARGIN = 0.05  # of the image, left free
LEAST_POINTS = 3  # of a pose: with fewer it is left out


@final
@dataclass(frozen=True)
class Ranges:
    """Ranges of random quantities, least and most."""

    poses: tuple[int, int] = (36, 72)  # of a run
    points: tuple[int, int] = (6, 12)  # of a pose
    pixel_px: tuple[float, float] = (0.06, 0.2)  # noise of a pixel
    target_m: tuple[float, float] = (2e-5, 6e-5)  # noise of a target point
    point_m: tuple[float, float] = (1e-5, 3e-5)  # noise of a point that a tracker measures
    repeats: int = 2  # images at each pose

    def count(self, name: str, rng: np.random.Generator) -> int:
        """A random number of poses or points."""
        least, most = getattr(self, name)
        return int(rng.integers(least, most + 1))

    def noise(self, name: str, rng: np.random.Generator) -> float:
        """A random standard deviation with three digits."""
        return float(f"{rng.uniform(*getattr(self, name)):.3g}")


def build(robot: Robot, ranges: Ranges, rng: np.random.Generator, *, moving: bool) -> World:
    """A random cell around any arm, which may be moving at the exposures."""
    quat = facing_outward(robot)
    drawing = scanner(quat)
    truth = built(drawing, rng, most=WORKSHOP, within=0.0)
    eye = ScannerOptics(truth, quat, "xyz", "u")
    n = ranges.count("poses", rng)
    view = View(eye.mount, truth, "u", IMAGE_PX)
    q, level = _postures(robot, view, n, rng)
    count = ranges.count("points", rng)
    first, last = view.stripe_range(MARGIN)
    step = (last - first) / count
    at = first + step * (np.arange(count) + 0.5 + rng.uniform(-0.3, 0.3, (n, count)))
    order = np.array([rng.permutation(3) for _ in range(n)])
    steps = LEVELS_M[order[:, np.arange(count) * 3 // count]]
    camera = robot.forward(q) @ eye.mount
    depth = (level - camera[:, 2, 3]) / camera[:, 2, 2]
    middle = np.append((camera[:, :2, 3] + depth[:, None] * camera[:, :2, 2]).mean(axis=0), level)
    qd = velocities(q, rng, moving=moving)
    time = pause_times(n, rng)
    run = SyntheticRun(robot, q, qd, time, middle, 0.15, float(rng.uniform(*PAYLOAD_KG)))
    of_pose = np.repeat(np.arange(n), count)
    cell = ScannerCell(run, eye, Target(middle, np.eye(3)), pose=of_pose, at=at.ravel(), level=steps.ravel())
    noise = Noise(pixel_px=ranges.noise("pixel_px", rng), target_m=ranges.noise("target_m", rng))
    poses = Poses(tuple(map(str, range(n))), time_s=time, q=q, qd=qd)
    blank = Dataset(
        name="blind", robot=robot, poses=poses, parameters=drawing, bracket_quat=quat, image_px=IMAGE_PX, noise=noise
    )
    return World(in_sight(cell, IMAGE_PX), blank, noise, ranges.repeats)


def velocities(q: Array, rng: np.random.Generator, *, moving: bool) -> Array:
    """Joint velocities at the exposures of poses, (n, j) -> (n, j) [rad/s or m/s]."""
    return rng.uniform(-SPEED, SPEED, q.shape) if moving else np.zeros(q.shape)


def pause_times(n: int, rng: np.random.Generator) -> Array:
    """Times of n poses, (n,) [s]."""
    return np.concatenate([[0.0], np.cumsum(rng.uniform(*PAUSE_S, n - 1))]).round(1)


def _postures(robot: Robot, view: View, n: int, rng: np.random.Generator) -> tuple[Array, float]:
    """Postures that see the target: all over the workspace, or around one of them as in usual cells."""
    wide, level = configurations_looking_down(robot, view, wanted=n, rng=rng)
    whole = wide[_sees(robot, wide, view, level)]
    chosen = wide = whole if len(whole) >= n else wide
    lower, upper = limits(robot)
    for home in wide[: 2 * ROUNDS] if rng.random() >= 0.3 else ():
        kept = np.empty((0, wide.shape[1]))
        for _ in range(ROUNDS):
            q = np.clip(home + rng.uniform(-AROUND, AROUND, (DRAWS // 10, len(home))), lower, upper)
            kept = np.concatenate([kept, q[_sees(robot, q, view, level)]])
            if len(kept) > 4 * n:
                break
        if len(kept) > 2 * n:
            chosen = kept[farthest_first(kept)]
            break
    return chosen[:n][rng.permutation(n)], level


def _sees(robot: Robot, q: Array, view: View, level: float) -> Bools:
    T = robot.forward(q) @ view.T_flange_camera
    at = np.linspace(*view.stripe_range(MARGIN), 3)[None]
    seen = -T[:, 2, 2] > np.cos(TILT)
    for step in LEVELS_M[[0, -1]]:
        with np.errstate(invalid="ignore"):
            seen &= view.contains(view.stripe(T, level + float(step), at), MARGIN).all(axis=1)
    return np.asarray(seen)


def in_sight(cell: ScannerCell, image_px: tuple[int, int]) -> ScannerCell:
    """The same cell without points that are invisible to the camera; a `TrialError` if no pose keeps enough of them."""
    pixel = cell.seen(())["pixel"]
    with np.errstate(invalid="ignore"):
        good = (np.abs(pixel / (np.array(image_px) - 1.0) - 0.5) < 0.5 - MARGIN / 2).all(axis=1)
    good &= np.bincount(cell.pose[good], minlength=len(cell.run.q))[cell.pose] >= LEAST_POINTS
    if not good.any():
        raise TrialError(
            f"No pose of such a blind data set has {LEAST_POINTS} points or more in view. Ask for more points, or take"
            " other data."
        )
    return replace(cell, pose=cell.pose[good], at=cell.at[good], level=cell.level[good])
