"""A calibrated scanner, read from calibration.json and the robot.urdf in its folder."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, final

import numpy as np

from robolaser.bounded_reading import ROBOT_BYTES, read_text
from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.calibration.saved import (
    CALIBRATION,
    FILES,
    SavedEffect,
    SavedModel,
    SavedNumber,
    SavedResult,
    numbers_of,
    read_result,
)
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.dataset_file import Pixels, check_rotation, inside
from robolaser.data.toml_schema import NotNegative, typed
from robolaser.errors import DataError, EffectError, ScanError, UsageError
from robolaser.geometry.rigid_motion import Quaternion
from robolaser.model.effects import found_effect
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.effects.run import RunSummary
from robolaser.model.sensors.stripe import SCANNER, Stripe
from robolaser.parameters import Parameter, Values, as_batch
from robolaser.robot.kinematics import Robot

_POSES = ("joint angles", "measured flange poses")


@final
@dataclass(frozen=True, kw_only=True)
class SavedScanner(SavedModel):
    """`model` of a stripe scanner's calibration."""

    stripe_axis: Literal["u", "v"]  # image axis that the stripe runs along
    bracket_quat: Quaternion  # nominal turn of the camera on the flange, (x, y, z, w)
    angles: Literal["xyz", "zyz"]  # order of the hand-eye angles
    image: tuple[Pixels, Pixels]
    sensors: tuple[dict[str, Any], ...] = ()  # name and kind of each of several


@final
@dataclass(frozen=True, kw_only=True)
class SavedScannerCalibration(SavedResult):
    """The entries of a stripe scanner's calibration.json that a scan needs."""

    dataset: str
    model: SavedScanner
    rms_m: NotNegative | None = None
    held_out_rms_m: NotNegative | None = None
    noise: dict[str, NotNegative] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class Calibrated:
    """A scanner on its arm, with the effects of its calibration.

    Attributes:
        name: Of the data set that it was calibrated from.
        origin: The source of its numbers, in words.
        parameters: The paper's fourteen before the calibration: nominal values, or those of the closed form.
        values: The estimated fourteen and numbers of the effects, (1,) each.
        candidates: The effects, in their order.
        robot: The nominal arm; None where flange poses were measured.
        model: Camera and arm of its file.
        noise: Standard deviation of each source of error, by name [px, m or rad].
        rms_m: Error of the calibration points, on new poses where that is known [m].
        run: The run that it was calibrated from; None where an older file does not state it.

    Examples:
        >>> read_calibration("scanner").as_drawn().effects
        ()
    """

    name: str
    origin: str
    parameters: Mapping[str, Parameter]
    values: Values
    candidates: tuple[CandidateEffect, ...]
    robot: Robot | None
    model: SavedScanner
    noise: Mapping[str, float]
    rms_m: float | None
    run: RunSummary | None

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects with their numbers."""
        return tuple(candidate_effect.at(self.values) for candidate_effect in self.candidates)

    @property
    def setup_warning(self) -> str | None:
        """A warning that the calibration describes the cell wrongly; None without evidence for this."""
        if self.rms_m is None or self.rms_m < SETUP_RMS_M:
            return None
        return (
            f"The calibration from {self.name} leaves points {100 * self.rms_m:.2g} cm off: no real arm has such an"
            " error, so it describes the cell wrongly. Do not use this cloud."
        )

    def as_drawn(self) -> "Calibrated":
        """The nominal scanner: before the fit, and without effects.

        Raises:
            ScanError: Some of its parameters have no nominal values.
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
        """The recording with the calibrated scanner and its arm as its description.

        Raises:
            ScanError: Sensor, image, arm or joints are those of another scanner.
        """
        same = (
            ("kind of sensor", recording.kind, Stripe.format.kind),
            ("stripe_axis", recording.stripe_axis, self.model.stripe_axis),
            ("image size", recording.image_px, self.model.image),
            ("poses", *(_POSES[one is None] for one in (recording.robot, self.robot))),
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
        arm: The recording's, for a file without its robot.urdf.

    Raises:
        DataError: It has another format or sensor, or a key is missing or invalid.
        EffectError: An effect is not known here, or cannot be at its location.
        RobotError: Its robot cannot be read.

    Examples:
        >>> read_calibration("scanner").name
        'paper'
    """
    path = Path(path)
    file = path / FILES[CALIBRATION] if path.is_dir() else path
    contents, result, _ = read_result(path, CALIBRATION)
    if result.model.sensor != Stripe.format.kind:
        raise _unusable(file, f'[model] sensor: {result.model.sensor!r}, expected "stripe"')
    saved = typed(contents, SavedScannerCalibration, file=str(file), others=True)
    model, robot = saved.model, _robot(file, saved.model, arm)
    check_rotation(model.bracket_quat, f"{file}, [model] bracket_quat", file.name)
    candidates = tuple(_candidate(file, effect, robot) for effect in saved.effects)
    if twice := [one for one in candidates if candidates.count(one) > 1]:
        raise _unusable(file, f"it has {twice[0]} twice")
    numbers, of_effects = numbers_of(contents), (name for one in candidates for name in one.parameters.names)
    names = [*SCANNER, *of_effects]
    if missing := [name for name in names if name not in numbers]:
        raise _unusable(file, f"it has no {', '.join(missing)}")
    own = next((f"{one.get('name')}." for one in model.sensors if one.get("kind") == Stripe.format.kind), "")
    return Calibrated(
        name=saved.dataset,
        origin=f"calibrated from {saved.dataset}",
        parameters={name: _parameter(file, name, saved.parameters[name]) for name in SCANNER},
        values=as_batch({name: numbers[name]["value"] for name in names}),
        candidates=candidates,
        robot=robot,
        model=model,
        noise={name.removeprefix(own): sigma for name, sigma in saved.noise.items()},
        rms_m=saved.rms_m if saved.held_out_rms_m is None else saved.held_out_rms_m,
        run=saved.run,
    )


def _parameter(file: Path, name: str, saved: SavedNumber) -> Parameter:
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
    return model.arm(read_text(urdf, ROBOT_BYTES) if arm is None or urdf.exists() else arm.urdf, urdf)


def _candidate(file: Path, saved: SavedEffect, robot: Robot | None) -> CandidateEffect:
    try:
        return found_effect(saved.effect, saved.where, robot)
    except UsageError as error:
        how = "Install the package that brings the effect, or calibrate again without it."
        raise EffectError(f"{file}: {error} {how}") from None


def _unusable(file: Path, reason: str) -> DataError:
    """The error of a file that is no calibration of a scanner."""
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
