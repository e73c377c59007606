"""Held-out errors of the files of a corrected arm: written without a fold's poses, read back, tested on these."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.calibration.result import Calibration, rms
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.subsampling import rows_of_each
from robolaser.diagnosis.fit import Fit, usual_sizes
from robolaser.diagnosis.validation import Transfer
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.folds import assign_folds, held_out
from robolaser.estimation.noise_weighted_fit import fit_by_noise
from robolaser.estimation.plain_fit import fit
from robolaser.estimation.solver import ENOUGH, SHARE, solve
from robolaser.export.controller_table import flange_by_table
from robolaser.export.corrected_arm import CorrectedArm
from robolaser.export.files import EXPORTED, is_withheld, missing_reader
from robolaser.export.mjcf import flange_by_mjcf
from robolaser.export.python_module import OF_THE_ARM, contained
from robolaser.export.sdf import flange_by_sdf
from robolaser.export.ur_calibration import flange_by_ur_calibration
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.mechanism import Play
from robolaser.model.effects.run import Course, Run
from robolaser.model.forward_model import Model
from robolaser.model.noise.covariance import FLOOR
from robolaser.robot.kinematics import Robot

Writer = Callable[[Calibration], str | None]
Reader = Callable[[str, Dataset, Bools], Array]  # flange poses of a data set's held poses, by a file's text
UNSEEN_POSES: Final = 150  # on which errors are measured: further folds are skipped, since they add nothing
PLACING_POSES: Final = 60  # to which base and tool are fitted: few files have them, and they differ between folds
PLACING_SESSION: Final = 12  # of these at least, in each session with unseen poses, whose base is its own. A judgement.
ALIKE: Final = 1e-7  # up to which two files have the flange at one place: tables have six digits of a millimetre [m, 1]
BEFORE: Final = 3  # poses before each: after a move shorter than its play, a joint stays where an earlier move left it


@final
@dataclass(frozen=True, eq=False)
class Delivered:
    """A file of the corrected arm, of the model with which its error is smallest."""

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
    """The files of the corrected arm with their errors on unseen poses, base and tool fitted to others.

    The rest of a model depends on effects that a file cannot hold: if a model fitted without them has a smaller error,
    the file is of that one. The calibration has its fits without each fold.
    """
    arm = calibration.model.dataset.robot
    own = tuple(one for one in calibration.model.effects if one.effect.stage in OF_THE_ARM)
    if arm is None or not own or is_withheld(calibration):
        return []
    alike = [one for one in calibration.model.effects if one.effect.looks_like_arm]
    run = calibration.model.run
    in_urdf = tuple(one for one in own if one.effect.in_urdf)
    in_mjcf = tuple(one for one in own if one.effect.in_urdf or one.at(calibration.values).parts(run))
    files: dict[str, tuple[Reader, tuple[CandidateEffect, ...]]] = {
        "corrected.py": (_by_module, contained(calibration.model)),
        "robot_corrected.urdf": (_by_arm(_flange_by_urdf), in_urdf),
        "robot_corrected.xml": (_by_mujoco, in_mjcf),
        "robot_corrected.sdf": (_by_arm(flange_by_sdf), in_urdf),
        "controller.csv": (_by_arm(flange_by_table), in_urdf),
        "calibration.yaml": (_by_arm(flange_by_ur_calibration), in_urdf),
    }
    whole = _Replay(calibration)
    fewer = {chosen for _, chosen in files.values() if chosen not in (own, ())}
    alone = {chosen: _Replay(_without_others(calibration, chosen)) for chosen in fewer}
    found, best_with = [], dict[tuple[CandidateEffect, ...], _Replay]()
    for name, (read, inside) in files.items():
        write = EXPORTED[name]
        if write(calibration) is None:
            continue
        tried = [whole, *([alone[inside]] if inside in alone else [])]
        errors = [None if missing_reader(name) else one.error(write, read) for one in tried]
        known = [error for error in errors if error is not None]
        best = tried[errors.index(min(known))] if known else best_with.get(inside, whole)
        best_with[inside] = best
        lacks = tuple(one for one in (*own, *alike) if one not in inside)
        text = write(best.calibration) or ""
        found.append(Delivered(name, text, min(known, default=None), inside, lacks))
    return found


def arm_in(files: Sequence[Delivered], arm: Robot | None) -> Robot | None:
    """The corrected arm of its URDF, which may be of a smaller model; of the model where there is no such file."""
    text = next((one.text for one in files if one.file == "robot_corrected.urdf"), None)
    if arm is None or text is None:
        return arm
    return Robot.from_urdf(text, flange=arm.flange, joints=arm.joints, gravity=arm.gravity)


def nearest_nominal(calibration: Calibration) -> Calibration:
    """The calibration; where its data do not determine effects, the one nearest to nominal that fits nearly as well.

    An optimum without priors may be anywhere along what the data do not determine, up to the bounds of the effects.
    """
    return _refitted(calibration, calibration.model.effects) if calibration.undetermined_effects else calibration


def _without_others(calibration: Calibration, chosen: Sequence[CandidateEffect]) -> Calibration:
    """The model with only some of the arm's effects, and those of the sensor, re-fitted."""
    return _refitted(
        calibration,
        tuple(one for one in calibration.model.effects if one in chosen or one.effect.stage not in OF_THE_ARM),
    )


def _refitted(calibration: Calibration, effects: Sequence[CandidateEffect]) -> Calibration:
    """The model with some of its effects, fitted with the weak priors of a diagnosis."""
    model = Model(calibration.model.dataset, tuple(effects))
    known = dict(zip(calibration.model.parameters.names, calibration.x.tolist(), strict=True))
    start = np.array([known[name] for name in model.parameters.names])
    weighted = None if calibration.weights == "plain" else fit_by_noise(model, start, seed=calibration.seed)
    problem, x = (weighted.problem, weighted.x) if weighted else fit(model, start)[:2]
    size = problem.with_rows_of_size(x).row_size or FLOOR
    problem = replace(problem, prior=usual_sizes(model, problem.parameters) / size)
    x = solve(problem, x[None]).x[0]
    folds = assign_folds(problem.model, calibration.seed)
    unseen = folds and (
        replace(weighted, problem=problem, x=x).held_out(folds) if weighted else held_out(problem, x, folds)
    )
    nothing, unknown = np.zeros(len(x), dtype=bool), np.full(len(x), np.nan)
    return replace(
        calibration, model=model, x=x, std=unknown, on_bound=nothing, unseen=unseen, fitted=problem.model, weighted=None
    )


@final
@dataclass(frozen=True, eq=False)
class _Fold:
    """A model without a fold's poses, and these poses with some more, which locate base and tool."""

    without: Calibration
    looked_at: Bools
    part: Dataset
    unseen: Bools  # rows of the fold's poses, (m,)
    rows: Bools  # those whose errors count, (m,)
    known: list[tuple[Array, Array]]

    def errors(self, flange: Array) -> Array:
        """Errors of the fold's rows from flange poses, (m, j) [m]; several files often have the same ones."""
        for there, errors in self.known:
            if np.abs(there - flange).max() < ALIKE:
                return errors
        course = self.without.fitted_model.run.course_at(self.looked_at)
        self.known.append((flange, _placed_anew(self.without, self.part, flange, self.unseen, course)[self.rows]))
        return self.known[-1][1]


@final
class _Replay:
    """Files of a model, written without each fold's poses."""

    def __init__(self, calibration: Calibration) -> None:
        self.calibration = calibration
        self._folds = list(_folds(calibration))

    def error(self, write: Writer, read: Reader) -> float | None:
        """Root mean square over the rows, each by the file written without its pose [m]."""
        data = self.calibration.fitted_model.dataset
        flanges = [read(write(fold.without) or "", data, fold.looked_at) for fold in self._folds]
        if not flanges or not all(np.isfinite(flange).all() for flange in flanges):  # a simulated arm may fly apart
            return None
        return rms(np.concatenate([fold.errors(flange) for fold, flange in zip(self._folds, flanges, strict=True)]))


def _folds(calibration: Calibration) -> Iterator[_Fold]:
    unseen, data = calibration.unseen, calibration.fitted_model.dataset
    if unseen is None:
        return
    count = 0
    is_known = np.ones(len(data.poses), dtype=bool)
    if any(isinstance(part, Play) for part in CorrectedArm(calibration).parts):
        is_known[[path[0] for path in data.paths]] = False  # no file holds the path of the arm with its play
    for number, x in enumerate(unseen.x):
        if count >= UNSEEN_POSES:
            return
        held: Bools = np.isin(np.arange(len(data.poses)), data.points.pose[unseen.of_row == number])
        looked_at, session = held.copy(), data.session_of_pose
        others = np.setdiff1d(data.points.pose[np.isin(session[data.points.pose], session[held])], np.flatnonzero(held))
        most = max(PLACING_POSES // len(np.unique(session[held])), PLACING_SESSION)
        looked_at[others[rows_of_each(session[others], most)]] = True
        part = data.of_poses(looked_at)
        of_row = np.flatnonzero(looked_at)[part.points.pose]
        count += int(held.sum())
        yield _Fold(replace(calibration, x=x), looked_at, part, held[of_row], (held & is_known)[of_row], [])


def _placed_anew(calibration: Calibration, part: Dataset, flange: Array, unseen: Bools, course: Course | None) -> Array:
    """Errors of rows from given flange poses, (m, j) [m]; base, tool and target are fitted to those not unseen."""
    model = calibration.model
    poses = Poses(part.poses.names, time_s=part.poses.time_s, session=part.poses.session, T_base_flange=flange)
    sensor = tuple(one for one in model.effects if one.effect.stage not in OF_THE_ARM)
    anew = {name for own in model.blocks.setup_parameters for name in (own, own.partition("@")[0])}
    values = dict(zip(model.parameters.names, calibration.x.tolist(), strict=True))
    of_arm = {item.name for one in model.effects if one not in sensor for item in one.parameters.items}
    held = {name: value for name, value in values.items() if name not in anew | of_arm}
    known = {
        item.name: replace(item, nominal=value, lower=value, upper=value, given=True)
        for item in model.sensor_parameters.items
        if (value := held.get(item.name)) is not None
    }  # no closed form need find it
    seen = AveragedData.single(replace(part, robot=None, poses=poses, parameters={**part.parameters, **known}))
    placing = Transfer.of(seen, lambda data: course, sensor, held, calibration.noise)
    problem = placing.problem
    x = solve(problem, placing.x[None], kept=~unseen[None], tol=SHARE, enough=ENOUGH).x
    errors = problem.plain(x)[0]
    if problem.model.blocks.held_out_groups is not None:
        errors = problem.model.blocks.relocated(errors)
    return np.asarray(Fit(problem, x[0]).in_metres(errors))


def _by_module(text: str, data: Dataset, held: Bools) -> Array:
    """Flange poses of the held poses by `corrected.py`."""
    module: dict[str, Any] = {}
    exec(compile(text, "corrected.py", "exec"), module)
    poses, (_, q) = data.poses, data.arm
    given = {"before": _before(data)[:, held]}
    time_s = None if poses.time_s is None else _since_beginning(data)
    for name, values in (("time_s", time_s), ("temperature_c", poses.temperature_c), ("velocity", poses.qd)):
        if values is not None:
            given[name] = values[held]
    return np.asarray(module["forward"](q[held], **given))


def _by_arm(read: Callable[[str, Robot, Array], Array]) -> Callable[[str, Dataset, Bools], Array]:
    """The same by a reader of a file that uses the arm's joint values alone."""
    return lambda text, data, held: read(text, data.arm[0], data.arm[1][held])


def _flange_by_urdf(text: str, robot: Robot, q: Array) -> Array:
    """T_base_flange by Pinocchio from a URDF, (n, j) -> (n, 4, 4)."""
    return Robot.from_urdf(text, flange=robot.flange, joints=robot.joints).forward(q)


def _by_mujoco(text: str, data: Dataset, held: Bools) -> Array:
    """The same by MuJoCo at rest; with play, on a path through the poses before."""
    robot, q = data.arm
    return flange_by_mjcf(text, robot, np.swapaxes(np.concatenate([_before(data), q[None]])[:, held], 0, 1))


def _since_beginning(data: Dataset) -> Array:
    """Times of the poses, (n,) [s], or their number, after the first of their session."""
    places, whole = data.in_whole(), data.whole or data
    since = np.zeros(len(whole.poses))
    for path in whole.paths:
        time_s = np.arange(len(path)) if whole.time_is_order else Run(whole).time_s[path]
        since[path] = time_s - time_s[0]
    return since if places is None else since[places]


def _before(data: Dataset) -> Array:
    """Joint values of the poses before each, the oldest first, (BEFORE, n, j); before a session's first, its first."""
    q = data.arm[1]
    before = np.empty((BEFORE, *q.shape))
    for path in data.paths:
        at = np.arange(len(path)) - np.arange(BEFORE, 0, -1)[:, None]
        before[:, path] = q[path[np.maximum(at, 0)]]
    return before
