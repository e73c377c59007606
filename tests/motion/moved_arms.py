"""Arms moved by MuJoCo under a controller of the tests, with faults that share no code with robolaser."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from mujoco.rollout import rollout

from robolaser.motion import simulation
from robolaser.motion.log import MotionLog
from robolaser.motion.reading import motion_texts
from robolaser.robot.kinematics import Robot

JOINTS = ("pan", "lift", "elbow", "wrist")
LENGTHS = (0.15, 0.4, 0.35, 0.1)
MASSES = (3.0, 4.0, 2.5, 0.8)
ROUND = (0.4, 0.1, 0.06, 0.04)  # inertia about each link's length [kg m²]
AXES = ((0, 0, 1), (0, 1, 0), (0, 1, 0), (1, 0, 0))
RATE_HZ = 100
PHYSICS_HZ = 1000
NOISE_RAD = 2e-5
MOTOR = 1.0  # inertia of a motor before an elastic gear [kg m²]
CARRIED_KG = "payload"


@dataclass
class World:
    """Faults of an arm, and parameters that the URDF lacks."""

    bandwidth: float = 80.0  # of each joint's critically damped position loop [rad/s]
    sluggish: float = 1.0  # damping relative to critical damping
    feeds_forward: bool = True  # by the URDF's masses and the commanded accelerations
    delay_s: float = 0.0
    clock_s: tuple[float, ...] = (0.0,)  # lead of the readings' time stamps, for each series in turn
    zero: dict[str, float] = field(default_factory=dict)
    dead: dict[str, float] = field(default_factory=dict)
    damping: dict[str, float] = field(default_factory=dict)
    dry: dict[str, float] = field(default_factory=dict)
    armature: dict[str, float] = field(default_factory=dict)
    payload_kg: float = 0.0
    spring: dict[str, float] = field(default_factory=dict)  # stiffness of the gear [Nm/rad]
    top_speed: dict[str, float] = field(default_factory=dict)  # limit of the drive's command speed [rad/s]
    gain: dict[str, float] = field(default_factory=dict)  # of recorded torques
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    wave: dict[str, float] = field(default_factory=dict)  # a fault outside the library: cubes of the angle
    pulled: dict[str, float] = field(default_factory=dict)  # another: stiffness of a spring beside the joint [Nm/rad]


def urdf() -> str:
    """The nominal arm."""
    links, joints, parent, at = [], [], "base", 0.0
    for name, axis, length, mass, own in zip(JOINTS, AXES, LENGTHS, MASSES, ROUND, strict=True):
        inertia = mass * length**2 / 12.0 + own
        links.append(
            f'<link name="{name}_link"><inertial><origin xyz="0 0 {length / 2}"/><mass value="{mass}"/><inertia'
            f' ixx="{inertia}" iyy="{inertia}" izz="{own}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
        joints.append(
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}_link"/><origin'
            f' xyz="0 0 {at}"/><axis xyz="{axis[0]} {axis[1]} {axis[2]}"/><limit lower="-2.5" upper="2.5"'
            ' effort="500" velocity="6"/></joint>'
        )
        parent, at = f"{name}_link", length
    tool = f'<link name="tool"/><joint name="end" type="fixed"><parent link="{parent}"/><child link="tool"/>'
    tool += f'<origin xyz="0 0 {at}"/></joint>'
    return f'<robot name="four"><link name="base"/>{"".join(links)}{"".join(joints)}{tool}</robot>'


ROBOT = Robot.from_urdf(urdf(), flange="tool", gravity=(0.0, 0.0, -9.81))


def mjcf(world: World) -> str:
    """The same arm for MuJoCo, with its faults."""
    inner, ends, at = "", "", 0.0
    for name, axis, length, mass, own in zip(JOINTS, AXES, LENGTHS, MASSES, ROUND, strict=True):
        inertia = mass * length**2 / 12.0 + own
        way = " ".join(map(str, axis))
        loss = (
            f'damping="{world.damping.get(name, 0.0)}" frictionloss="{world.dry.get(name, 0.0)}"'
            f' armature="{world.armature.get(name, MOTOR if name in world.spring else 0.0)}"'
            f' stiffness="{world.pulled.get(name, 0.0)}"'
        )
        if name in world.spring:
            inner += (
                f'<body name="{name}_motor" pos="0 0 {at}"><joint name="{name}" axis="{way}" {loss}/>'
                '<inertial mass="0.001" pos="0 0 0" diaginertia="1e-3 1e-3 1e-3"/>'
                f'<body name="{name}_link"><joint name="{name}_gear" axis="{way}" stiffness="{world.spring[name]}"'
                ' damping="40"/>'
            )
            ends += "</body></body>"
        else:
            inner += f'<body name="{name}_link" pos="0 0 {at}"><joint name="{name}" axis="{way}" {loss}/>'
            ends += "</body>"
        inner += f'<inertial mass="{mass}" pos="0 0 {length / 2}" diaginertia="{inertia} {inertia} {own}"/>'
        at = length
    if world.payload_kg:
        inner += f'<body pos="0 0 {at}"><inertial mass="{world.payload_kg}" pos="0 0 0" diaginertia="1e-4 1e-4 1e-4"/>'
        inner += "</body>"
    motors = "".join(f'<motor joint="{name}" name="{name}"/>' for name in JOINTS)
    down = " ".join(map(str, world.gravity))
    return (
        f'<mujoco><option timestep="{1 / PHYSICS_HZ}" integrator="implicitfast" gravity="{down}"/><compiler'
        f' autolimits="true"/><worldbody>{inner}{ends}</worldbody><actuator>{motors}</actuator></mujoco>'
    )


def written(log: MotionLog, folder: Path) -> Path:
    folder.mkdir(exist_ok=True)
    for name, text in motion_texts(log).items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def _gains(model: mujoco.MjModel, world: World) -> tuple[np.ndarray, np.ndarray]:
    data, pushed = mujoco.MjData(model), np.zeros((len(JOINTS), len(JOINTS)))
    mujoco.mj_forward(model, data)
    for joint, row in enumerate(pushed):
        mujoco.mj_mulM(model, data, row, np.eye(len(JOINTS))[joint])
    kp = np.diag(pushed) * world.bandwidth**2
    return kp, 2.0 * world.sluggish * kp / world.bandwidth


RECORDED: dict[str, MotionLog] = {}


def record(world: World, *, series: int = 6, seconds: float = 12.0, seed: int = 0, rate_hz: int = RATE_HZ) -> MotionLog:
    """A log of the arm in its world, simulated once."""
    key = repr((world, series, seconds, seed, rate_hz))
    if key not in RECORDED:
        RECORDED[key] = _recorded(world, series, seconds, seed, rate_hz)
    return RECORDED[key]


def simulated(*, seconds: float, rate_hz: float = 100.0, robot: Robot | None = None, **options: Any) -> MotionLog:
    """A log of `simulate_motion` with runs of so many seconds: the longest run determines the time of a search."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulation, "DURATION_S", seconds)
        patch.setattr(simulation, "RATE_HZ", rate_hz)
        return simulation.simulate_motion(robot or ROBOT, **options)


@contextmanager
def _dead_bands(goal: np.ndarray, kp: np.ndarray, dead: np.ndarray, address: list[int]) -> Iterator[None]:
    """Let controllers take no notice of errors up to `dead` [rad]."""

    def within(_: mujoco.MjModel, data: mujoco.MjData) -> None:
        error = goal[round(data.time * PHYSICS_HZ)] - data.qpos[address]
        data.ctrl[:] -= kp * np.clip(error, -dead, dead)

    mujoco.set_mjcb_control(within if dead.any() else None)
    try:
        yield
    finally:
        mujoco.set_mjcb_control(None)


def _recorded(world: World, series: int, seconds: float, seed: int, rate_hz: int) -> MotionLog:
    rng = np.random.default_rng(seed)
    real = mujoco.MjModel.from_xml_string(mjcf(world))
    ideal = mujoco.MjModel.from_xml_string(mjcf(World()))
    kp, kd = _gains(ideal, world)
    real.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER  # takes the controller's torques as they are
    real.actuator_biastype[:] = mujoco.mjtBias.mjBIAS_AFFINE
    real.actuator_biasprm[:, 1:3] = np.column_stack([-kp, -kd])
    steps, every = round(seconds * PHYSICS_HZ), PHYSICS_HZ // rate_hz
    time = np.arange(steps) / PHYSICS_HZ
    address = [real.joint(name).qposadr[0] for name in JOINTS]
    gear = [real.joint(f"{name}_gear").qposadr[0] if name in world.spring else None for name in JOINTS]
    late = round(world.delay_s * PHYSICS_HZ)
    zero, dead, gain, cubes = (
        np.array([table.get(name, default) for name in JOINTS])
        for table, default in ((world.zero, 0.0), (world.dead, 0.0), (world.gain, 1.0), (world.wave, 0.0))
    )
    top = np.array([world.top_speed.get(name, np.inf) for name in JOINTS])
    tables: dict[str, list[np.ndarray]] = {name: [] for name in ("time", "command", "q", "tau", "load")}
    for number in range(series):
        amplitude = rng.uniform(0.2, 0.5, (4, len(JOINTS))) / np.arange(1, 5)[:, None]
        rate = 2.0 * np.pi * rng.uniform(0.05, 0.5, (4, len(JOINTS)))
        angle = rate * time[:, None, None] + rng.uniform(0.0, 2.0 * np.pi, (4, len(JOINTS)))
        pause = 0.5 - 0.5 * np.cos(np.pi * np.clip(time / 1.0, 0.0, 1.0))[:, None]
        middle = rng.uniform(-0.4, 0.4, len(JOINTS)) + np.array([0.0, 0.7, 0.6, 0.0])
        command = middle + pause * (amplitude * np.sin(angle)).sum(axis=1)
        sent = np.concatenate([np.repeat(command[:1], late, axis=0), command[: steps - late]])
        if np.isfinite(top).any():
            slow = sent.copy()
            for i in range(1, steps):
                slow[i] = slow[i - 1] + np.clip(sent[i] - slow[i - 1], -top / PHYSICS_HZ, top / PHYSICS_HZ)
            sent = slow
        speed = np.gradient(sent, 1.0 / PHYSICS_HZ, axis=0)
        acceleration = np.gradient(speed, 1.0 / PHYSICS_HZ, axis=0)
        goal, ahead = sent + zero + cubes * sent**3, np.zeros_like(sent)
        if world.feeds_forward:
            model = mujoco.MjData(ideal)
            for i in range(steps):
                model.qpos[:], model.qvel[:], model.qacc[:] = sent[i], speed[i], acceleration[i]
                mujoco.mj_inverse(ideal, model)
                ahead[i] = model.qfrc_inverse
            ahead += kd * speed
        data = mujoco.MjData(real)
        data.qpos[address] = sent[0]
        state = np.empty((1, steps, 1 + real.nq + real.nv))
        state[0, 0] = [0.0, *data.qpos, *data.qvel]
        with _dead_bands(goal, kp, dead, address):
            state[:, 1:], _ = rollout(real, data, state[0, :1], (kp * goal + ahead)[None, :-1])
        angles, speeds = np.split(state[0, :, 1:], [real.nq], axis=1)
        read, turning = angles[:, address], speeds[:, address]
        error = goal - read
        torque = kp * (error - np.clip(error, -dead, dead)) - kd * turning + ahead
        behind = read + np.stack([np.zeros(steps) if g is None else angles[:, g] for g in gear], axis=1)
        early = round(world.clock_s[number % len(world.clock_s)] * PHYSICS_HZ)
        rows = np.arange(0, steps - early, every)
        tables["time"].append(rows / PHYSICS_HZ)
        tables["command"].append(command[rows])
        for name, values in (("q", read), ("tau", torque * gain), ("load", behind)):
            tables[name].append(values[rows + early])
    count = [len(part) for part in tables["time"]]
    parts = {name: np.concatenate(values) for name, values in tables.items()}
    shaken = {name: rng.normal(size=parts["q"].shape) for name in ("q", "tau", "load")}
    none = np.full_like(parts["q"], np.nan)
    load = parts["load"] + NOISE_RAD * shaken["load"] if world.spring else none
    return MotionLog(
        name="four", robot=ROBOT,
        series=tuple(f"run_{i}" for i in range(series)), run=np.repeat(np.arange(series), count), time_s=parts["time"],
        command=parts["command"], q=parts["q"] + NOISE_RAD * shaken["q"], qd=none,
        tau=parts["tau"] + 0.02 * shaken["tau"], load=load,
    )  # fmt: skip
