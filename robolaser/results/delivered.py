"""What the files of a diagnosis deliver: each is written without a fold's poses, read back, and held against these."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.util import find_spec
from typing import Any, Final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.calibration.result import Calibration, rms
from robolaser.data.dataset import Dataset, Poses
from robolaser.diagnosis.result import Diagnosis
from robolaser.diagnosis.validation import Transfer
from robolaser.estimation.averaging import AveragedData
from robolaser.export.files import is_withheld
from robolaser.export.mjcf import mjcf
from robolaser.export.python_module import OF_THE_ARM, corrected_module
from robolaser.export.urdf import corrected_urdf
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.run_summary import RunSummary
from robolaser.robot.kinematics import Robot

Reader = Callable[[str, Dataset, Bools], Array | None]
"""Gives the flange poses of the held poses of a data set, by a file's text."""
PLACING_POSES: Final = 150
"""Beside the unseen ones, to which base and tool are fitted: they are in no file, and each fold has them elsewhere."""
REST_S: Final = 0.3
"""In which MuJoCo's springs come to rest. A judgement."""


def files_json(diagnosis: Diagnosis, calibration: Calibration) -> list[dict[str, Any]]:
    """The files of the corrected arm: the error of each on unseen poses, base and tool fitted, and its effects.

    Args:
        diagnosis: What was found.
        calibration: The corrected model.

    Returns:
        `file`, `held_out_mm` (null where no reader is installed, or nothing was held out), `contains` and `lacks`.
    """
    arm = calibration.model.dataset.robot
    own = [one for one in calibration.model.effects if one.effect.stage in OF_THE_ARM]
    if arm is None or not own or is_withheld(calibration):
        return []
    run = calibration.model.run
    values = calibration.model.parameters.values(calibration.x[None])
    files: list[tuple[str, Callable[[Calibration], str | None], Reader | None, list[CandidateEffect]]] = [
        ("corrected.py", corrected_module, _by_module, own),
        ("robot_corrected.urdf", corrected_urdf, _by_urdf, [one for one in own if one.effect.in_urdf]),
        (
            "robot_corrected.xml",
            mjcf,
            _by_mujoco if find_spec("mujoco") else None,
            [one for one in own if one.effect.in_urdf or one.at(values).parts(run)],
        ),
    ]
    found = []
    for name, write, read, contained in files:
        if write(calibration) is None:
            continue
        error = None if read is None else _error(diagnosis, calibration, write, read)
        found.append({
            "file": name,
            "held_out_mm": None if error is None else 1e3 * error,
            "contains": [[one.effect.name, one.where] for one in contained],
            "lacks": [[one.effect.name, one.where] for one in own if one not in contained],
        })  # fmt: skip
    return found


def _error(
    diagnosis: Diagnosis,
    calibration: Calibration,
    write: Callable[[Calibration], str | None],
    read: Reader,
) -> float | None:
    """Root mean square over the rows, each seen by the file that was written without its pose [m]."""
    if diagnosis.by_folds is None:
        return None
    fold, fits = diagnosis.by_folds
    data = diagnosis.observed
    errors = []
    for number, x in enumerate(fits):
        held = np.zeros(len(data.poses), dtype=bool)
        held[data.points.pose[fold == number]] = True
        others = np.flatnonzero(~held)
        looked_at = held.copy()
        looked_at[others[:: max(1, len(others) // PLACING_POSES)]] = True
        flange = read(write(replace(calibration, x=x)) or "", data, looked_at)
        if flange is None:
            return None
        part = data.of_poses(looked_at)
        unseen = held[np.flatnonzero(looked_at)[part.points.pose]]
        errors.append(_placed_anew(diagnosis, x, part, flange)[unseen])
    return rms(np.concatenate(errors))


def _placed_anew(diagnosis: Diagnosis, x: Array, part: Dataset, flange: Array) -> Array:
    """Errors of rows seen from given flange poses, (m, j) [m]; where base, tool and target are is fitted to them."""
    model = diagnosis.model
    poses = Poses(part.poses.names, time_s=part.poses.time_s, session=part.poses.session, T_base_flange=flange)
    sensor = tuple(one for one in model.effects if one.effect.stage not in OF_THE_ARM)
    anew = {name for own in model.blocks.put_anew for name in (own, own.partition("@")[0])}
    values = dict(zip(model.parameters.names, x.tolist(), strict=True))
    of_arm = {item.name for one in model.effects if one not in sensor for item in one.parameters.items}
    held = {name: value for name, value in values.items() if name not in anew | of_arm}
    seen = AveragedData.of(replace(part, robot=None, poses=poses))
    fit = Transfer.of(seen, RunSummary.of(diagnosis.dataset), sensor, held).fit()
    return np.asarray(fit.in_metres(fit.at.plain))


def _by_module(text: str, data: Dataset, held: Bools) -> Array:
    """Flange poses of the held poses by `corrected.py`."""
    module: dict[str, Any] = {}
    exec(compile(text, "corrected.py", "exec"), module)
    poses, (_, q) = data.poses, data.arm
    order = np.arange(len(q)) if poses.time_s is None else np.argsort(poses.time_s, kind="stable")
    before = np.empty_like(q)
    before[order] = q[np.concatenate([order[:1], order[:-1]])]
    given = {"before": before[held]}
    for name, values in (("time_s", poses.time_s), ("temperature_c", poses.temperature_c), ("velocity", poses.qd)):
        if values is not None:
            given[name] = (values - (values.min() if name == "time_s" else 0.0))[held]
    return np.asarray(module["forward"](q[held], **given))


def _by_urdf(text: str, data: Dataset, held: Bools) -> Array:
    """The same by Pinocchio from a URDF."""
    robot, q = data.arm
    return np.asarray(Robot.from_urdf(text, flange=robot.flange, joints=robot.joints).forward(q[None, held])[0])


def _by_mujoco(text: str, data: Dataset, held: Bools) -> Array | None:
    """The same where MuJoCo comes to rest; None where play asks along which path."""
    import mujoco  # noqa: PLC0415 - an extra

    model = mujoco.MjModel.from_xml_string(text)
    if model.ntendon:
        return None
    robot, q = data.arm
    state = mujoco.MjData(model)
    columns = [int(model.joint(name).qposadr[0]) for name in robot.joints]
    model.dof_armature[columns] = 1e6
    steps = round(REST_S / model.opt.timestep) if model.nv > len(columns) else 0
    return np.stack([_at_rest(mujoco, model, state, columns, goal, steps, robot.flange) for goal in q[held]])


def _at_rest(
    mujoco: Any, model: Any, state: Any, columns: Sequence[int], goal: Array, steps: int, flange: str
) -> Array:
    for _ in range(steps):
        state.qpos[columns], state.qvel[columns] = goal, 0.0
        mujoco.mj_step(model, state)
    state.qpos[columns] = goal
    mujoco.mj_forward(model, state)
    body = model.body(flange).id
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = state.xmat[body].reshape(3, 3), state.xpos[body]
    return T
