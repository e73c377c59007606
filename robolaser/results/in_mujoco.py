"""Where MuJoCo has the flange of a corrected arm: at rest, after the moves that decide on which side a play is."""

from itertools import pairwise
from typing import Any, Final

import numpy as np

from robolaser.arrays import Array
from robolaser.robot.kinematics import Robot

BEYOND_PLAY: Final = 0.03  # end of a joint's move, longer than any play: earlier positions do not matter [rad, m]
WAY_S: Final = 0.1  # in which MuJoCo drives the ends of an arm's moves. A judgement: faster, a link slips in its play.
REST_S: Final = 2.0  # in which an arm comes to rest at most. A judgement: heavy arms swing on soft gears for a second.
ROUNDS: Final = 4  # in which springs find where they hold the links, each with a hundredth of the error before
STILL: Final = 1e-5  # speed and change of speed in a step below which an arm is at rest [rad/s, m/s]


def flange_in_mujoco(text: str, robot: Robot, paths: Array) -> Array:
    """Flange poses of an MJCF at the ends of paths of its joint values, (n, p, j) -> (n, 4, 4).

    NaN where the simulation diverges: MuJoCo would reset, and would report that on the terminal and in a file of the
    current folder.
    """
    import mujoco  # noqa: PLC0415 - an extra

    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        return _simulated(mujoco.MjModel.from_xml_string(text), robot, paths)
    finally:
        mujoco.set_mju_user_warning(previous)


def _simulated(model: Any, robot: Robot, paths: Array) -> Array:
    import mujoco  # noqa: PLC0415 - an extra

    bad = [getattr(mujoco.mjtWarning, f"mjWARN_BAD{what}") for what in ("QPOS", "QVEL", "QACC")]
    state = mujoco.MjData(model)
    columns = [int(model.joint(name).qposadr[0]) for name in robot.joints]
    model.dof_armature[columns] = 1e6
    step_s, qpos, qvel = model.opt.timestep, state.qpos, state.qvel  # views, which take longer to get than to fill
    steps, rest = (round(duration / step_s) for duration in (WAY_S, REST_S))
    shares = (1.0 - np.cos(np.pi * np.arange(1, steps + 1) / steps))[:, None] / 2.0
    (springs,) = np.nonzero(model.jnt_stiffness)
    stiffness, sprung, loaded = model.jnt_stiffness[springs], model.jnt_qposadr[springs], model.jnt_dofadr[springs]
    flange, found = model.body(robot.flange).id, np.tile(np.eye(4), (len(paths), 1, 1))
    for T, path in zip(found, paths, strict=True):
        mujoco.mj_resetData(model, state)
        way = _ends(path)
        qpos[columns] = way[0]
        for _ in range(ROUNDS if len(springs) else 0):
            mujoco.mj_forward(model, state)
            qpos[sprung] = -state.qfrc_bias[loaded] / stiffness
        for before, then in pairwise(way if model.ntendon else way[-1:]):
            for now in before + shares * (then - before):
                qvel[columns] = (now - qpos[columns]) / step_s
                mujoco.mj_step(model, state)
        for _ in range(rest if model.nv > len(columns) else 0):
            qpos[columns], qvel[columns] = path[-1], 0.0
            mujoco.mj_step(model, state)
            if max(np.abs(qvel).max(), step_s * np.abs(state.qacc).max()) < STILL:
                break
        qpos[columns] = path[-1]
        mujoco.mj_forward(model, state)
        T[:3, :3], T[:3, 3] = state.xmat[flange].reshape(3, 3), state.xpos[flange]
        if any(state.warning[one].number for one in bad):
            return np.full_like(found, np.nan)
    return found


def _ends(path: Array) -> Array:
    """A path (p, j) with the same end and the same plays there, of short moves, from the last that all joints made."""
    moves = np.diff(path, axis=0)
    (all_moved,) = np.nonzero(np.abs(moves).min(axis=1) > BEYOND_PLAY)
    short = np.clip(moves, -BEYOND_PLAY, BEYOND_PLAY)[all_moved.max(initial=0) :]
    return np.concatenate([path[-1] - np.cumsum(short[::-1], axis=0)[::-1], path[-1:]])
