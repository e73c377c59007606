"""A scanner as a calibration left it, read from calibration.json and the robot.urdf beside it."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import msgspec
import numpy as np

from robolaser.bounded_reading import ROBOT_BYTES, read_text
from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.dataset_file import QUATERNION_SLACK, inside
from robolaser.errors import DataError, EffectError, ScanError, near
from robolaser.model import effects as library
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.sensors.stripe import SCANNER, Stripe
from robolaser.parameters import Parameter, Values, as_batch
from robolaser.robot.kinematics import DOWN, Robot
from robolaser.scan.saved_calibration import SavedCalibration, SavedEffect, SavedModel, SavedParameter

FILE = "calibration.json"


@final
@dataclass(frozen=True)
class Calibrated:
    """A scanner on its arm, with the effects that were found.

    Attributes:
        name: Of the data set that it was calibrated from.
        origin: Where its numbers come from, in words.
        parameters: The paper's fourteen, as they were before the calibration; where nobody gave a nominal value, the
            closed form's.
        values: The fourteen and the numbers of the effects as they were found, (1,) each.
        candidates: The effects, in their order.
        robot: The nominal arm; None where flange poses were measured.
        model: What its file says of camera and arm.
        noise: Standard deviation of each source of error, by name [px, m or rad].
        rms_m: Error of the calibration points, on new poses where that is known [m].
        run: The run that it was calibrated from; None where an older file does not say.

    Examples:
        >>> from robolaser.scan import read_calibration
        >>> robolaser.calibrate(dataset).save("calibrated")
        >>> read_calibration("calibrated").as_drawn().effects
        ()
    """

    name: str
    origin: str
    parameters: Mapping[str, Parameter]
    values: Values
    candidates: tuple[CandidateEffect, ...]
    robot: Robot | None
    model: SavedModel
    noise: Mapping[str, float]
    rms_m: float | None
    run: RunSummary | None

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects with their numbers."""
        return tuple(candidate_effect.at(self.values) for candidate_effect in self.candidates)

    @property
    def setup_warning(self) -> str | None:
        """A warning that the calibration describes the cell wrongly; None where nothing points to that."""
        if self.rms_m is None or self.rms_m < SETUP_RMS_M:
            return None
        return (
            f"The calibration from {self.name} leaves points {100 * self.rms_m:.2g} cm off: no real arm has such an"
            " error, so it describes the cell wrongly. Do not use this cloud."
        )

    def as_drawn(self) -> "Calibrated":
        """The nominal scanner: before anything was fitted, and without effects.

        Raises:
            ScanError: Nobody gave nominal values for some of its parameters.
        """
        missing = [name for name, item in self.parameters.items() if not item.given]
        if missing:
            raise ScanError(
                f"There is no nominal model of {self.name}: its [parameters] gave no {', '.join(missing)}, so the"
                " calibration started from closed forms. Leave out --nominal."
            )
        nominal = as_batch({name: item.nominal for name, item in self.parameters.items()})
        origin = f"by the nominal model of {self.name}"
        noise = {key: sigma for key, sigma in self.noise.items() if key == "pixel"}
        return replace(self, origin=origin, values=nominal, candidates=(), noise=noise, rms_m=None)

    def fitted_to(self, recording: Dataset) -> Dataset:
        """The recording as if the calibrated scanner and its arm were described in it.

        Raises:
            ScanError: Sensor, image, arm or joints are of another scanner.
        """
        same = (
            ("kind of sensor", recording.kind, Stripe.format.kind),
            ("stripe_axis", recording.stripe_axis, self.model.stripe_axis),
            ("image size", recording.image_px, self.model.image),
            ("poses", _kind_of_poses(recording.robot), _kind_of_poses(self.robot)),
        )
        for what, found, expected in same:
            if found != expected:
                raise _of_another_scanner(what, found, expected)
        return replace(
            recording,
            robot=self.robot,
            poses=self._posed(recording.poses, recording.robot),
            parameters=self.parameters,
            bracket_quat=self.model.bracket_quat,
            angles=self.model.angles,
        )

    def _posed(self, poses: Poses, robot: Robot | None) -> Poses:
        if robot is None or self.robot is None or poses.q is None:
            return poses
        if set(robot.joints) != set(self.robot.joints):
            raise _of_another_scanner("joints", ", ".join(robot.joints), ", ".join(self.robot.joints))
        order = [robot.joints.index(joint) for joint in self.robot.joints]
        qd = None if poses.qd is None else np.ascontiguousarray(poses.qd[:, order])
        return replace(poses, q=np.ascontiguousarray(poses.q[:, order]), qd=qd)


def read_calibration(path: str | Path, arm: Robot | None = None) -> Calibrated:
    """Read calibration.json.

    Args:
        path: The file, or the folder that it is in.
        arm: The recording's, to be taken where the file stands alone, without its robot.urdf beside it.

    Raises:
        DataError: It is of another format, lacks something, or has something impossible, or is of another sensor.
        EffectError: An effect is not known here.
        DataError, RobotError: It or the robot beside it cannot be read.

    Examples:
        >>> from robolaser.scan import read_calibration
        >>> robolaser.calibrate(dataset).save("scanner")
        >>> read_calibration("scanner").name
        'paper'
    """
    path = Path(path)
    file = path / FILE if path.is_dir() else path
    if not file.exists():
        what = f"has no {FILE}" if path.is_dir() else "does not exist"
        raise DataError(f"{path} {what}. Name the folder that `robolaser calibrate` wrote, or its {FILE}.", file=path)
    try:
        saved = msgspec.json.decode(read_text(file), type=SavedCalibration)
    except msgspec.ValidationError as error:
        reason = re.sub(r"Invalid enum value (.*) - at `\$\.(.*)`", r"its \2 is \1", str(error))
        raise _unusable(file, reason) from None
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise _unusable(file, f"it is not JSON ({error})") from None
    model, robot = saved.model, _robot(file, saved.model, arm)
    norm = float(np.linalg.norm(model.bracket_quat))
    if abs(norm - 1) > QUATERNION_SLACK:
        raise _unusable(file, f"model.bracket_quat has length {norm:g}, but a rotation has length 1")
    parameters = {name: _parameter(file, name, saved.parameters.get(name)) for name in SCANNER}
    values = {name: np.array([saved.parameters[name].value]) for name in SCANNER}
    candidates = _candidates(file, saved.effects, robot)
    for candidate, effect in zip(candidates, saved.effects, strict=True):
        for key in candidate.parameters.names:
            name = key.rsplit(".", 1)[-1]
            if name not in effect.parameters:
                raise _unusable(file, f"its {effect.effect} at {effect.where} has no parameter {name}")
            values[key] = np.array([effect.parameters[name].value])
    return Calibrated(
        name=saved.dataset,
        origin=f"calibrated from {saved.dataset}",
        parameters=parameters,
        values=values,
        candidates=candidates,
        robot=robot,
        model=model,
        noise=saved.noise,
        rms_m=saved.rms_m if saved.held_out_rms_m is None else saved.held_out_rms_m,
        run=saved.run,
    )


def _parameter(file: Path, name: str, saved: SavedParameter | None) -> Parameter:
    if saved is None:
        raise _unusable(file, f"it has no parameters.{name}")
    if name in Stripe.format.positive and not saved.value > 0:
        raise _unusable(file, f"parameters.{name}.value is {saved.value:g}, not above 0")
    start = saved.start if saved.nominal is None else saved.nominal
    if start is None:
        raise _unusable(file, f"parameters.{name} has neither nominal nor start")
    lower, upper = -np.inf if saved.lower is None else saved.lower, np.inf if saved.upper is None else saved.upper
    return Parameter(name, Stripe.format.unit_of(name), start, lower, upper, given=saved.nominal is not None)


def _robot(file: Path, model: SavedModel, arm: Robot | None) -> Robot | None:
    if model.robot is None:
        return None
    urdf = inside(file.parent, model.robot, f"{file.name}, model.robot")
    return Robot.from_urdf(
        read_text(urdf, ROBOT_BYTES) if arm is None or urdf.exists() else arm.urdf,
        flange=model.flange or "",
        joints=model.joints,
        gravity=model.gravity or DOWN,
        source=str(urdf),
    )


def _candidates(file: Path, saved: Sequence[SavedEffect], robot: Robot | None) -> tuple[CandidateEffect, ...]:
    """The effects that the file names: each is known here, at a location where it can be, and there once."""
    known = {effect.name: effect for effect in library.EFFECTS}
    found: list[CandidateEffect] = []
    for name, where in ((one.effect, one.where) for one in saved):
        if name not in known:
            raise EffectError(
                f"{file} has the effect '{name}' in its model, which is not known here.{near(name, known)} Install"
                " the package that provides it, or calibrate again without it."
            )
        locations = known[name].sites(robot)
        if where not in locations:
            which = f"it can be at {', '.join(locations)}" if locations else "its arm has no joint for it"
            raise _unusable(file, f"its {name} is at '{where}', where it cannot be: {which}")
        candidate = CandidateEffect(known[name], where)
        if candidate in found:
            raise _unusable(file, f"it has {name} at {where} twice")
        found.append(candidate)
    return tuple(found)


def _unusable(file: Path, reason: str) -> DataError:
    """The file is no calibration of a scanner."""
    return DataError(
        f"Cannot use {file}: {reason}. Expected calibration.json of a stripe scanner as `robolaser calibrate` or"
        " `robolaser diagnose` writes it, robot.urdf beside it.",
        file=file,
    )


def _of_another_scanner(what: str, found: object, expected: object) -> ScanError:
    return ScanError(
        f"The recording's {what} is {found}, but the calibration's is {expected}: they belong to different scanners."
        " Use the calibration of the scanner that made the recording, or correct dataset.toml."
    )


def _kind_of_poses(robot: Robot | None) -> str:
    return "measured flange poses" if robot is None else "joint angles"
