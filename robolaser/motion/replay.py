"""A log replayed in MuJoCo: the distance of a simulated arm from the real one under the same commands."""

from pathlib import Path
from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import DataError, RobotError
from robolaser.motion.gap import root_mean_squares
from robolaser.motion.log import MotionLog, filled
from robolaser.plugins import extra

MOST_S = 60.0  # of each run that is replayed


def replay(model: Path, log: MotionLog) -> dict[str, float]:
    """Drive the arm of an MJCF file, whose position actuators are at joints of the log's names, by its commands.

    Returns:
        Root-mean-square difference of each driven joint from its readings [rad].

    Raises:
        DependencyMissing: MuJoCo is not installed.
        RobotError: MuJoCo cannot load or simulate the file, or no actuator drives a joint of the log.
        DataError: The log has no commands.
    """
    mujoco = extra("mujoco", "A replay needs MuJoCo, which is not installed: pip install 'robolaser[mujoco]'.")
    if not log.has("command").any():
        raise DataError(
            "The log has no commands to replay: motion.csv has no column command_<joint>.", file="motion.csv"
        )
    try:
        simulated = mujoco.MjModel.from_xml_path(str(model))
    except ValueError as fault:
        raise RobotError(f"MuJoCo cannot load {model.name}: {str(fault).splitlines()[0]}") from None
    driven = {}
    for number in range(simulated.nu):
        if simulated.actuator_trntype[number] != mujoco.mjtTrn.mjTRN_JOINT:
            continue  # it drives a tendon or a site, of any number
        name = simulated.joint(int(simulated.actuator(number).trnid[0])).name
        if name in log.joints and log.has("command")[log.joints.index(name)]:
            driven[log.joints.index(name)] = (number, int(simulated.joint(name).qposadr[0]))
    if not driven:
        raise RobotError(f"{model.name} has no actuator at a joint of the log: {', '.join(log.joints)}.")
    errors = np.concatenate([_run(mujoco, simulated, log, rows, driven) for rows in log.rows_of_runs])
    return {log.joints[joint]: float(size) for joint, size in zip(driven, root_mean_squares(errors), strict=True)}


def _run(mujoco: Any, model: Any, log: MotionLog, rows: slice, driven: dict[int, tuple[int, int]]) -> Array:
    """Simulated less measured angles of the driven joints in one run, (n, k)."""
    data = mujoco.MjData(model)
    first, read, command = rows.start, *(np.nan_to_num(filled(values[rows])[0]) for values in (log.q, log.command))
    for joint, (actuator, address) in driven.items():
        data.qpos[address], data.ctrl[actuator] = read[joint], command[joint]
    out = []
    for row in range(first, rows.stop):
        time = float(log.time_s[row])
        if time > MOST_S:
            break
        while data.time < time:
            mujoco.mj_step(model, data)
            if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:  # it begins anew, at time zero
                raise RobotError(
                    f"The replay of {log.series[log.run[row]]} is unstable {time:.3g} s from its start: give the MJCF's"
                    " joints damping or armature, or reduce its timestep."
                )
        out.append([data.qpos[address] - log.q[row, joint] for joint, (_, address) in driven.items()])
        for joint, (actuator, _) in driven.items():
            if np.isfinite(log.command[row, joint]):
                data.ctrl[actuator] = log.command[row, joint]
    return np.array(out).reshape(-1, len(driven))
