"""What the files of a corrected arm deliver: written without a fold's poses, read back, held against these."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any, Final, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.calibration.result import Calibration, rms
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.subsampling import evenly
from robolaser.diagnosis.validation import Transfer
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.folds import assign_folds, held_out
from robolaser.estimation.noise_weighted_fit import fit_by_noise
from robolaser.estimation.robust_reweighting import fit
from robolaser.export.files import is_withheld
from robolaser.export.mjcf import mjcf
from robolaser.export.python_module import OF_THE_ARM, corrected_module
from robolaser.export.urdf import corrected_urdf
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.forward_model import Model
from robolaser.robot.kinematics import Robot

Writer = Callable[[Calibration], str | None]
Reader = Callable[[str, Dataset, Bools], Array | None]
"""Gives the flange poses of the held poses of a data set, by a file's text."""
UNSEEN_POSES: Final = 300
"""On which errors are measured at most: more say no more."""
PLACING_POSES: Final = 60
"""Beside the unseen ones, to which base and tool are fitted: they are in no file, and each fold has them elsewhere."""
REST_S: Final = 0.3
"""In which MuJoCo's springs come to rest. A judgement."""


@final
@dataclass(frozen=True, eq=False)
class Delivered:
    """A file of the corrected arm, by the model that it delivers most with."""

    file: str
    text: str
    held_out_m: float | None
    contains: tuple[CandidateEffect, ...]
    lacks: tuple[CandidateEffect, ...]

    def to_dict(self) -> dict[str, Any]:
        """As in calibration.json and diagnosis.json."""
        return {
            "file": self.file,
            "held_out_mm": None if self.held_out_m is None else 1e3 * self.held_out_m,
            "contains": [[one.effect.name, one.where] for one in self.contains],
            "lacks": [[one.effect.name, one.where] for one in self.lacks],
        }


def delivered(calibration: Calibration) -> list[Delivered]:
    """The files of the corrected arm with their errors on unseen poses, base and tool fitted.

    What a file cannot hold, the rest of the model leans on: where one fitted without it delivers more, the file is of
    that one.

    Args:
        calibration: The corrected model, with its fits without each fold.
    """
    arm = calibration.model.dataset.robot
    own = tuple(one for one in calibration.model.effects if one.effect.stage in OF_THE_ARM)
    if arm is None or not own or is_withheld(calibration):
        return []
    run = calibration.model.run
    values = calibration.model.parameters.values(calibration.x[None])
    in_urdf = tuple(one for one in own if one.effect.in_urdf)
    in_mjcf = tuple(one for one in own if one.effect.in_urdf or one.at(values).parts(run))
    files: list[tuple[str, Writer, Reader | None, tuple[CandidateEffect, ...]]] = [
        ("corrected.py", corrected_module, _by_module, own),
        ("robot_corrected.urdf", corrected_urdf, _by_urdf, in_urdf),
        ("robot_corrected.xml", mjcf, _by_mujoco if find_spec("mujoco") else None, in_mjcf),
    ]
    alone = {chosen: _without_others(calibration, chosen) for _, _, _, chosen in files if chosen not in (own, ())}
    found = []
    for name, write, read, contained in files:
        if write(calibration) is None:
            continue
        tried = [calibration, *([alone[contained]] if contained in alone else [])]
        errors = [None if read is None else _error(one, write, read) for one in tried]
        known = [error for error in errors if error is not None]
        best = tried[errors.index(min(known))] if known else calibration
        lacks = tuple(one for one in own if one not in contained)
        text = write(best) or ""
        found.append(Delivered(name, text, min(known, default=None), contained, lacks))
    return found


def _without_others(calibration: Calibration, chosen: Sequence[CandidateEffect]) -> Calibration:
    """The model with only some of the arm's effects, and those of the sensor, fitted anew."""
    kept = [one for one in calibration.model.effects if one in chosen or one.effect.stage not in OF_THE_ARM]
    model = Model(calibration.model.dataset, tuple(kept))
    known = dict(zip(calibration.model.parameters.names, calibration.x.tolist(), strict=True))
    start = np.array([known[name] for name in model.parameters.names])
    if calibration.weights == "plain":
        problem, x, _ = fit(model, start, loss=calibration.loss)
        folds = assign_folds(problem.model, calibration.seed)
        unseen = None if folds is None else held_out(problem, x, folds)
    else:
        weighted = fit_by_noise(model, start, seed=calibration.seed)
        problem, x = weighted.problem, weighted.x
        folds = assign_folds(problem.model, calibration.seed)
        unseen = None if folds is None else weighted.held_out(folds)
    nothing, unknown = np.zeros(len(x), dtype=bool), np.full(len(x), np.nan)
    return replace(
        calibration, model=model, x=x, std=unknown, on_bound=nothing, unseen=unseen, fitted=problem.model, weighted=None
    )


def _error(calibration: Calibration, write: Writer, read: Reader) -> float | None:
    """Root mean square over the rows, each seen by the file that was written without its pose [m]."""
    unseen = calibration.unseen
    if unseen is None:
        return None
    data, errors = calibration.fitted_model.dataset, []
    for number, x in enumerate(unseen.x):
        of_fold = np.isin(np.arange(len(data.poses)), data.points.pose[unseen.of_row == number])
        held, looked_at = (np.zeros(len(data.poses), dtype=bool) for _ in range(2))
        held[_some(of_fold, UNSEEN_POSES // len(unseen.x))] = True
        looked_at[_some(~of_fold, PLACING_POSES)] = True
        looked_at |= held
        without = replace(calibration, x=x)
        flange = read(write(without) or "", data, looked_at)
        if flange is None:
            return None
        part = data.of_poses(looked_at)
        rows = held[np.flatnonzero(looked_at)[part.points.pose]]
        errors.append(_placed_anew(without, part, flange)[rows])
    return rms(np.concatenate(errors))


def _some(chosen: Bools, most: int) -> Ints:
    numbers = np.flatnonzero(chosen)
    return numbers[evenly(len(numbers), most)]


def _placed_anew(calibration: Calibration, part: Dataset, flange: Array) -> Array:
    """Errors of rows seen from given flange poses, (m, j) [m]; where base, tool and target are is fitted to them."""
    model = calibration.model
    poses = Poses(part.poses.names, time_s=part.poses.time_s, session=part.poses.session, T_base_flange=flange)
    sensor = tuple(one for one in model.effects if one.effect.stage not in OF_THE_ARM)
    anew = {name for own in model.blocks.put_anew for name in (own, own.partition("@")[0])}
    values = dict(zip(model.parameters.names, calibration.x.tolist(), strict=True))
    of_arm = {item.name for one in model.effects if one not in sensor for item in one.parameters.items}
    held = {name: value for name, value in values.items() if name not in anew | of_arm}
    seen = AveragedData.of(replace(part, robot=None, poses=poses))
    fit = Transfer.of(seen, RunSummary.of(model.dataset), sensor, held).fit()
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
