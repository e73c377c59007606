"""A calibrated scanner, read from calibration.json and the robot.urdf beside it."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, final

import msgspec
import numpy as np

from robolaser.bounded_reading import ROBOT_BYTES, read_text
from robolaser.data.dataset_file import QUATERNION_SLACK, Pixels, inside
from robolaser.data.toml_schema import NotNegative
from robolaser.errors import DataError, EffectError, near
from robolaser.model import effects as library
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.sensors.stripe import SCANNER, Stripe
from robolaser.parameters import Parameter
from robolaser.robot.kinematics import DOWN, Robot
from robolaser.scan.calibrated import Calibrated

FILE = "calibration.json"


@final
@dataclass(frozen=True)
class SavedModel:
    """`model` of a stripe scanner's calibration."""

    sensor: Literal["stripe"]
    stripe_axis: Literal["u", "v"]
    bracket_quat: tuple[float, float, float, float]
    angles: Literal["xyz", "zyz"]
    image: tuple[Pixels, Pixels]
    robot: str | None = None
    flange: str | None = None
    joints: tuple[str, ...] | None = None
    gravity: tuple[float, float, float] | None = None


@final
@dataclass(frozen=True)
class SavedParameter:
    """A number as it was found; of the scanner's, nominal value and bounds, or where it started without these, too."""

    value: float
    nominal: float | None = None
    lower: float | None = None
    upper: float | None = None
    start: float | None = None


@final
@dataclass(frozen=True)
class SavedEffect:
    """An effect at a location."""

    effect: str
    where: str
    parameters: dict[str, SavedParameter]


@final
@dataclass(frozen=True)
class SavedCalibration:
    """calibration.json of a stripe scanner, as far as a scan needs it."""

    format: Literal["robolaser-calibration/1"]
    dataset: str
    parameters: dict[str, SavedParameter]
    model: SavedModel
    effects: list[SavedEffect]
    rms_m: NotNegative | None = None
    held_out_rms_m: NotNegative | None = None
    noise: dict[str, NotNegative] = field(default_factory=dict)
    run: RunSummary | None = None


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
        raise _unusable(file, str(error)) from None
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
        stripe_axis=model.stripe_axis,
        bracket_quat=model.bracket_quat,
        angles=model.angles,
        image_px=model.image,
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
