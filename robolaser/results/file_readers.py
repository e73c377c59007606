"""The flange by each file of a corrected arm, as the program sees it that the file is for."""

from collections.abc import Callable
from itertools import pairwise
from typing import Any, Final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.robot.kinematics import Robot

BEFORE: Final = 3
"""Poses before each: after a move shorter than its play, a joint is where an earlier move left it."""
BEYOND_PLAY: Final = 0.03
"""[rad, m] Move of a joint that no play outlasts: where it was before no longer counts."""
WAY_S: Final = 0.6
"""In which MuJoCo drives an arm with play from one pose to the next. A judgement."""
REST_S: Final = 0.3
"""In which MuJoCo's springs come to rest. A judgement."""


def by_module(text: str, data: Dataset, held: Bools) -> Array:
    """Flange poses of the held poses by `corrected.py`."""
    module: dict[str, Any] = {}
    exec(compile(text, "corrected.py", "exec"), module)
    poses, (_, q) = data.poses, data.arm
    given = {"before": _before(data)[:, held]}
    time_s = None if poses.time_s is None else _since_beginning(data, poses.time_s)
    for name, values in (("time_s", time_s), ("temperature_c", poses.temperature_c), ("velocity", poses.qd)):
        if values is not None:
            given[name] = values[held]
    return np.asarray(module["forward"](q[held], **given))


def by_arm(read: Callable[[str, Robot, Array], Array]) -> Callable[[str, Dataset, Bools], Array]:
    """The same by what reads a file and computes with the arm's joint values alone."""
    return lambda text, data, held: read(text, data.arm[0], data.arm[1][held])


def flange_by_urdf(text: str, robot: Robot, q: Array) -> Array:
    """T_base_flange by Pinocchio from a URDF, (n, j) -> (n, 4, 4)."""
    return np.asarray(Robot.from_urdf(text, flange=robot.flange, joints=robot.joints).forward(q[None])[0])


def by_mujoco(text: str, data: Dataset, held: Bools) -> Array:
    """The same where MuJoCo comes to rest; where a gear has play, on its way through the poses before."""
    import mujoco  # noqa: PLC0415 - an extra

    model = mujoco.MjModel.from_xml_string(text)
    robot, q = data.arm
    state = mujoco.MjData(model)
    columns = [int(model.joint(name).qposadr[0]) for name in robot.joints]
    model.dof_armature[columns] = 1e6
    step_s, qpos, qvel = model.opt.timestep, state.qpos, state.qvel  # views, which take longer to get than to fill
    steps, rest = (round(duration / step_s) for duration in (WAY_S, REST_S))
    shares = (1.0 - np.cos(np.pi * np.arange(1, steps + 1) / steps))[:, None] / 2.0
    shares = shares if model.ntendon else shares[:0]
    flange, found = model.body(robot.flange).id, np.tile(np.eye(4), (int(held.sum()), 1, 1))
    paths = np.swapaxes(np.concatenate([_before(data), q[None]])[:, held], 0, 1)
    for T, path in zip(found, paths, strict=True):
        mujoco.mj_resetData(model, state)
        (known,) = np.nonzero(np.abs(np.diff(path, axis=0)).min(axis=1) > BEYOND_PLAY)
        way, goal = path[known.max(initial=0) :], path[-1]
        qpos[columns] = way[0]
        for now in np.concatenate([before + shares * (then - before) for before, then in pairwise(way)]):
            qvel[columns] = (now - qpos[columns]) / step_s
            mujoco.mj_step(model, state)
        for _ in range(rest if model.nv > len(columns) else 0):
            qpos[columns], qvel[columns] = goal, 0.0
            mujoco.mj_step(model, state)
        qpos[columns] = goal
        mujoco.mj_forward(model, state)
        T[:3, :3], T[:3, 3] = state.xmat[flange].reshape(3, 3), state.xpos[flange]
    return found


def _since_beginning(data: Dataset, time_s: Array) -> Array:
    """Times of the poses since the first of their session, (n,) [s]."""
    since = time_s.copy()
    for path in data.paths:
        since[path] -= time_s[path[0]]
    return since


def _before(data: Dataset) -> Array:
    """Joint values of the poses before each, the oldest first, (BEFORE, n, j); before a session's first, its first."""
    q = data.arm[1]
    before = np.empty((BEFORE, *q.shape))
    for path in data.paths:
        at = np.arange(len(path)) - np.arange(BEFORE, 0, -1)[:, None]
        before[:, path] = q[path[np.maximum(at, 0)]]
    return before
