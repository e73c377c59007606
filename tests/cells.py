"""Small cells with known truth and known errors, built in memory."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.geometry.camera import metric, rays, undistort
from robolaser.geometry.rigid_motion import apply, exp_so3, from_angles, inverse, pose
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import motion
from robolaser.model.sensors.stripe import SCANNER, Stripe
from robolaser.parameters import Parameter, Values
from robolaser.robot.by_name import find_robot

TRUTH = {
    "f": 0.008, "s_u": 7.4e-6, "s_v": 7.5e-6, "u_0": 322.0, "v_0": 238.0, "k": 800.0, "b": 0.14, "theta": 0.45,
    "w": 0.02, "phi": -0.03, "psi": 0.015, "t_x": 0.07, "t_y": -0.005, "t_z": -0.065,
    "target.x": 0.5, "target.y": 0.1, "target.z": 0.02, "target.w": 0.03, "target.phi": -0.02, "target.psi": 0.3,
    "base.x": 0.1, "base.y": -2.0, "base.z": 0.3, "base.w": 0.1, "base.phi": -0.2, "base.psi": 0.4,
    "tool.a.x": 0.05, "tool.a.y": 0.02, "tool.a.z": 0.1,
    "tool.b.x": -0.04, "tool.b.y": 0.06, "tool.b.z": 0.08,
    "tool.c.x": 0.01, "tool.c.y": -0.05, "tool.c.z": 0.12,
}  # fmt: skip
WIDTH = {"m": 0.2, "rad": 0.5, "px": 200.0, "1/m²": 1e4, "m/px": 1e-5}
SIX = ("x", "y", "z", "w", "phi", "psi")


def on_flange_poses(dataset: Dataset) -> Dataset:
    """The same on measured flange poses, of an arm of which nothing else is known."""
    return replace(dataset, robot=None, poses=replace(dataset.poses, q=None, qd=None, T_base_flange=dataset.flange()))


@final
@dataclass(frozen=True)
class Cell:
    """A data set without errors, and its true parameters."""

    dataset: Dataset

    def model(self, *candidate_effects: CandidateEffect) -> Model:
        """The forward model of its sensor."""
        return Model(self.dataset, candidate_effects)

    def truth(self, model: Model) -> Array:
        """The optimum without errors; effects are absent."""
        return np.array([TRUTH.get(name, 0.0) for name in model.parameters.names])

    def missed(self) -> Array:
        """Residuals at the truth, (m, 3), without the closed form that a model starts from."""
        model = self.model()
        values = at_truth(model.blocks.free + model.blocks.derived)
        perturb = model.perturb(values)
        return model.blocks.residuals(values, model.flange(values, perturb), perturb)[0]

    def shaken(
        self,
        rng: np.random.Generator,
        *,
        pixel: float = 0.0,
        target: float = 0.0,
        point: float = 0.0,
        joint: float = 0.0,
        flange: float = 0.0,
    ) -> "Cell":
        """The same cell measured with errors of these standard deviations."""
        ds = self.dataset
        poses, points = ds.poses, ds.points
        if poses.q is not None:
            poses = replace(poses, q=poses.q + joint * rng.standard_normal(poses.q.shape))
        if poses.T_base_flange is not None:
            T = poses.T_base_flange.copy()
            T[:, :3, 3] += flange * rng.standard_normal((len(T), 3))
            poses = replace(poses, T_base_flange=T)
        if points.xyz is not None:
            keys = list(zip(points.pose.tolist(), points.names, strict=True))
            of_point = {key: rng.standard_normal(3) for key in dict.fromkeys(keys)}
            xyz = points.xyz + target * np.array([of_point[key] for key in keys])
            points = replace(points, xyz=xyz + point * rng.standard_normal(xyz.shape))
        if points.pixel is not None:
            seen = points.pixel + pixel * rng.standard_normal(points.pixel.shape)
            points = replace(points, pixel=seen)
            if ds.board is not None and points.xyz is not None:
                moved = on_board(self, seen) - on_board(self, ds.points.pixel)
                points = replace(points, xyz=points.xyz + moved)
        return Cell(replace(ds, poses=poses, points=points))


def at_truth(names: tuple[str, ...]) -> dict[str, Array]:
    """The truth as a batch of one."""
    return {name: np.array([TRUTH[name]]) for name in names}


def given(names: tuple[str, ...], **nominal: float) -> dict[str, Parameter]:
    """Parameters of a data set, with bounds too wide to be active."""
    out = {}
    for name in names:
        at, half = nominal.get(name, TRUTH[name]), WIDTH[Stripe.format.unit_of(name)] / 2
        out[name] = Parameter(name, Stripe.format.unit_of(name), at, at - half, at + half)
    return out


def stripe_cell(
    rng: np.random.Generator,
    *,
    poses: int,
    points: int,
    repeats: int = 1,
    robot: str | None = None,
    angles: str = "xyz",
) -> Cell:
    """A stripe scanner; its target points are the intersections of the pixels' rays with the laser plane."""
    m = poses * points * repeats
    pixel = np.column_stack([rng.uniform(40, 600, m // repeats), rng.uniform(40, 440, m // repeats)])
    bare = Dataset(
        name="cell",
        poses=_stood(rng, poses, robot),
        points=Points(
            pose=np.repeat(np.arange(poses), points * repeats),
            names=tuple(str(i) for _ in range(poses) for i in range(points) for _ in range(repeats)),
            repeat=None if repeats == 1 else np.tile(np.arange(repeats), m // repeats),
            pixel=pixel.repeat(repeats, axis=0),
            xyz=np.zeros((m, 3)),
        ),
        robot=None if robot is None else find_robot(robot),
        parameters=given(SCANNER),
        angles=angles,
    )
    return Cell(replace(bare, points=replace(bare.points, xyz=-Cell(bare).missed())))


def board_cell(rng: np.random.Generator, *, poses: int, points: int) -> Cell:
    """A stripe on a board, both seen by the camera; the target points are the stripe pixels projected on the board."""
    names = SCANNER + tuple(f"target.{part}" for part in SIX)
    values = at_truth(names)
    T_base_target = motion(values, "target")
    mount = pose(from_angles(values["w"], values["phi"], values["psi"]), np.array([[0.07, -0.005, -0.065]]))
    T_target_camera = pose(
        exp_so3(rng.normal(0, 0.25, (poses, 3))),
        np.column_stack([rng.normal(0, 0.05, (poses, 2)), rng.uniform(-0.33, -0.24, poses)]),
    )
    T_base_flange = T_base_target @ T_target_camera @ inverse(mount)
    along = np.tile(np.linspace(-1.8e-3, 1.8e-3, points), poses)
    T = T_target_camera.repeat(points, axis=0)
    theta, f = TRUTH["theta"], TRUTH["f"]
    A = np.zeros((poses * points, 3, 3))
    A[:, 0] = np.cos(theta), 0.0, np.sin(theta)
    A[:, 1] = T[:, 2, :3]
    A[:, 2, 1], A[:, 2, 2] = 1.0, along / f
    right = np.stack([np.full(len(A), TRUTH["b"] * np.cos(theta)), -T[:, 2, 3], np.zeros(len(A))], axis=-1)
    in_camera = np.linalg.solve(A, right[..., None])[..., 0]
    dataset = Dataset(
        name="board",
        poses=Poses(names=tuple(map(str, range(poses))), T_base_flange=T_base_flange),
        points=Points(
            pose=np.repeat(np.arange(poses), points),
            names=tuple(str(i) for _ in range(poses) for i in range(points)),
            pixel=project(in_camera[None], values, "u")[0],
            xyz=apply(T, in_camera),
        ),
        parameters=given(names),
        board=Board(7, 6, 0.01),
        placed=False,
    )
    return Cell(dataset)


def on_board(cell: Cell, pixel: Array) -> Array:
    """Intersections of the rays of pixels (m, 2) with the true board, in its frame, (m, 3)."""
    model = cell.model()
    values = model.parameters.values(cell.truth(model)[None])
    perturb = model.perturb(values)
    T_target_camera = (
        inverse(motion(values, "target"))
        @ (model.flange(values, perturb) @ model.blocks.sensor.in_cell(values, perturb).mount)[0]
    )[cell.dataset.points.pose]
    ray = rays(undistort(metric(pixel[None], values), values["k"]), values["f"], "u")[0]
    direction = np.einsum("mij,mj->mi", T_target_camera[:, :3, :3], ray)
    centre = T_target_camera[:, :3, 3]
    return centre - direction * (centre[:, 2:] / direction[:, 2:])


def tracker_cell(rng: np.random.Generator, *, poses: int, robot: str) -> Cell:
    """A tracker with three reflectors on the flange of a robot."""
    names = tuple(name for name in TRUTH if name.startswith(("base.", "tool.")))
    bare = Dataset(
        name="tracker",
        kind="point",
        poses=_stood(rng, poses, robot),
        points=Points(pose=np.repeat(np.arange(poses), 3), names=tuple("abc") * poses, xyz=np.zeros((3 * poses, 3))),
        robot=find_robot(robot),
        parameters=given(names),
    )
    return Cell(replace(bare, points=replace(bare.points, xyz=-Cell(bare).missed())))


def _stood(rng: np.random.Generator, poses: int, robot: str | None) -> Poses:
    names = tuple(map(str, range(poses)))
    if robot is not None:
        return Poses(names=names, q=rng.uniform(-1.0, 1.0, (poses, len(find_robot(robot).joints))))
    T = pose(exp_so3(rng.normal(0, 0.7, (poses, 3))), rng.normal(0, 0.2, (poses, 3)))
    return Poses(names=names, T_base_flange=T)


def project(point: Array, values: Values, stripe_axis: str) -> Array:
    """Project points to pixels: the inverse of the camera's rays.

    The radial polynomial is inverted by Newton's method.

    Args:
        point: In the camera frame, (c, m, 3) [m].
        values: Uses `f`, `s_u`, `s_v`, `u_0`, `v_0`, `k`.
        stripe_axis: As in `rays`.

    Returns:
        (c, m, 2) [px]; NaN behind the camera and where the distortion has no inverse.
    """
    x, y = (point[..., i] / point[..., 2] * values["f"][:, None] for i in (0, 1))
    undistorted = np.stack([-y, x] if stripe_axis == "u" else [x, y], axis=-1)
    k = values["k"][:, None]
    radius = np.linalg.norm(undistorted, axis=-1)
    distorted = radius.copy()
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for _ in range(12):
            slope = 1.0 + 3.0 * k * distorted**2
            distorted = distorted - (distorted * (1.0 + k * distorted**2) - radius) / slope
        missed = ~(np.abs(distorted * (1.0 + k * distorted**2) - radius) <= 1e-12 + 1e-9 * radius)
        shrink = np.where(radius > 0, distorted / radius, 1.0)
    shrink = np.where(missed | (point[..., 2] <= 0) | (distorted < 0), np.nan, shrink)
    pitch = np.stack([values["s_u"], values["s_v"]], axis=-1)[:, None]
    centre = np.stack([values["u_0"], values["v_0"]], axis=-1)[:, None]
    return undistorted * shrink[..., None] / pitch + centre
