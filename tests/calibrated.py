"""Small calibrations of every kind of sensor, composed without a search."""

from dataclasses import replace

import numpy as np

from robolaser import find_robot
from robolaser.calibration.pymoo_search import History
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.stated_noise import Noise
from robolaser.estimation.identifiability import Unidentifiable
from robolaser.geometry.rigid_motion import exp_so3, pose, to_quaternion
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.stripe import Stripe
from robolaser.parameters import Parameter
from robolaser.robot.kinematics import Robot
from robolaser.simulation import simulate

NOMINAL = {
    "f": (8e-3, 6e-3, 10e-3), "s_u": (7.4e-6, 5e-6, 1e-5), "s_v": (7.4e-6, 5e-6, 1e-5), "u_0": (320, 290, 340),
    "v_0": (240, 200, 250), "k": (600.0, 0.0, 1e4), "b": (0.14, 0.1, 0.2), "theta": (0.44, 0.0, 0.8),
    "w": (0.0, -0.1, 0.1), "phi": (0.0, -0.1, 0.1), "psi": (0.0, -0.1, 0.1),
    "t_x": (0.07, 0.05, 0.1), "t_y": (-0.005, -0.01, 0.0), "t_z": (-0.065, -0.1, -0.05),
}  # fmt: skip

ARM = """<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/><link name="one"/><link name="slide"/><link name="two"/><link name="flange"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="one"/>
    <origin xyz="0 0 0.3" rpy="0 0.2 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
  <joint name="lift" type="prismatic"><parent link="one"/><child link="slide"/>
    <origin xyz="0.1 0 0" rpy="0.1 0 0.3"/><axis xyz="0 0.6 0.8"/><limit lower="0" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="perturb" type="revolute"><parent link="slide"/><child link="two"/>
    <origin xyz="0.2 0 0.1" rpy="1.2 0 0"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/>
  </joint>
  <joint name="plate" type="fixed"><parent link="two"/><child link="flange"/><origin xyz="0 0 0.2" rpy="0 3 0"/></joint>
</robot>
"""
POSES, ROWS = 8, 6


def arm():
    return Robot.from_urdf(ARM, flange="flange")


def poses(rng, robot):
    names = tuple(f"p{i}" for i in range(POSES))
    if robot is None:
        T = pose(exp_so3(rng.normal(scale=0.4, size=(POSES, 3))), rng.uniform(-0.3, 0.3, (POSES, 3)))
        return Poses(names, T_base_flange=T)
    return Poses(names, q=rng.uniform(0.1, 0.9, (POSES, 3)))


def stripe(*, robot=None, effects=(), name="made up", axis="u", k=600.0):
    rng = np.random.default_rng(3)
    along, across = rng.uniform(40, 600, POSES * ROWS), rng.uniform(200, 280, POSES * ROWS)
    points = Points(
        pose=np.repeat(np.arange(POSES), ROWS),
        names=tuple(str(i % ROWS) for i in range(POSES * ROWS)),
        pixel=np.stack([along, across] if axis == "u" else [across, 0.7 * along], axis=-1),
        xyz=np.zeros((POSES * ROWS, 3)),
    )
    parameters = {key: Parameter(key, Stripe.format.unit_of(key), *map(float, three)) for key, three in NOMINAL.items()}
    parameters["k"] = replace(parameters["k"], nominal=k)
    dataset = Dataset(
        name=name, poses=poses(rng, robot), points=points, robot=robot, parameters=parameters,
        image_px=(640, 480), stripe_axis=axis, bracket_quat=(0.1, -0.3, 0.2, 0.9),
        noise=Noise(pixel_px=0.1, target_m=5e-5), source=f"{name}, a made-up laboratory", licence="CC0",
    )  # fmt: skip
    model = Model(dataset, candidate_effects(effects, dataset))
    away = model.parameters.nominal + 0.05 * rng.uniform(-1, 1, len(model.parameters)) * model.parameters.width
    away[0] = model.parameters.nominal[0]
    values = model.parameters.values(away[None])
    perturb = model.perturb(values)
    seen = scanner_geometry.in_base(model.blocks.sensor.dataset, values, model.flange(values, perturb), perturb)[0]
    dataset = replace(dataset, points=replace(points, xyz=seen + rng.normal(scale=1e-4, size=seen.shape)))
    return finished(Model(dataset, model.effects), away)


def point(*, names=("left", "right"), name="tracked"):
    rng = np.random.default_rng(4)
    robot = arm()
    where = poses(rng, robot)
    tools = {one: rng.uniform(-0.1, 0.1, 3) for one in names}
    flange = robot.forward(where.q[None])[0]
    xyz = np.array([T[:3, :3] @ tools[one] + T[:3, 3] for T in flange for one in names])
    points = Points(
        pose=np.repeat(np.arange(POSES), len(names)),
        names=tuple(names) * POSES,
        xyz=xyz + rng.normal(scale=1e-4, size=xyz.shape),
    )
    model = Model(Dataset(name, where, points, kind="point", robot=robot, noise=Noise(point_m=2e-5)))
    return finished(model, model.parameters.nominal)


def body(*, name="body"):
    rng = np.random.default_rng(5)
    robot = arm()
    where = poses(rng, robot)
    T = robot.forward(where.q[None])[0]
    points = Points(
        pose=np.arange(POSES),
        names=("0",) * POSES,
        xyz=T[:, :3, 3] + 1e-3 * rng.normal(size=(POSES, 3)),
        columns={"quaternion": to_quaternion(T[:, :3, :3])},
    )
    model = Model(Dataset(name, where, points, kind="pose", robot=robot, noise=Noise(point_m=1e-3, angle_rad=1e-4)))
    return finished(model, model.parameters.nominal)


def socket(*, name="seated"):
    rng = np.random.default_rng(5)
    robot = arm()
    points = Points(pose=np.arange(POSES), names=("0", "1") * (POSES // 2))
    model = Model(Dataset(name, poses(rng, robot), points, kind="socket", robot=robot))
    return finished(model, model.parameters.nominal)


def simulated(kind):
    noise = Noise(pixel_px=0.1, point_m=2e-5)
    made = simulate(
        find_robot("scorbot_er7"), kind=kind, poses=POSES, points=12 if kind == "camera" else 2, noise=noise, seed=5
    )
    model = Model(made.dataset)
    return finished(model, model.parameters.nominal)


def finished(model, x):
    rng = np.random.default_rng(6)
    parameters = model.parameters
    std = rng.uniform(1e-4, 1e-3, len(x)) * parameters.width
    std[np.isin(parameters.names, model.blocks.fixed)] = np.nan
    residuals = model.residuals(x[None])[0]
    noise = {
        "stripe": {"pixel": 0.1, "target": 5e-5, "joint": 1e-5},
        "point": {"point": 2e-5, "joint": 1e-5},
        "pose": {"point": 1e-3, "angle": 1e-4},
        "camera": {"pixel": 0.1, "joint": 1e-5},
        "profile": {"point": 2e-5, "joint": 1e-5},
    }
    free = tuple(model.blocks.free)
    history = None
    if free:
        wandering = parameters.lower + parameters.width * rng.uniform(size=(20, len(x)))
        history = History(parameters.names, 100 * np.arange(1, 21), np.geomspace(1.0, 1e-5, 20), wandering)
    return Calibration(
        model=model,
        algorithm="rcga" if free else "gauss-newton",
        weights="plain",
        seed=7,
        x=x,
        std=std,
        on_bound=np.zeros(len(x), dtype=bool),
        unidentifiable=(Unidentifiable(("f", "s_u", "s_v", "k"), "They change together & nothing moves."),)
        if free
        else (),
        residuals=residuals,
        held_out=1.1 * model.in_metres(x, residuals),
        noise=noise.get(model.dataset.kind, {"seat": 1e-5, "joint": 1e-5}),
        history=history,
        evaluations=2000,
        seconds=1.5,
        warnings=("b ended <nearly> on its bound.",),
    )


KINDS = {
    "stripe": lambda: stripe(robot=arm()), "point": point, "pose": body, "socket": socket,
    "camera": lambda: simulated("camera"), "profile": lambda: simulated("profile"),
}  # fmt: skip


def bent(dataset, sizes):
    """A calibration of an arm with effects of these sizes, keyed by EFFECT:WHERE.NUMBER."""
    model = Model(dataset, candidate_effects(tuple(dict.fromkeys(name.rpartition(".")[0] for name in sizes)), dataset))
    x = model.parameters.nominal.copy()
    for name, size in sizes.items():
        x[model.parameters.names.index(name.replace(":", "."))] = size
    return finished(model, x)
