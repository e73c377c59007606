"""A scanner as a calibration left it: what calibration.json and the robot.urdf beside it say."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

import numpy as np

from robolaser.bounded_reading import ROBOT_BYTES, read_json, read_text
from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.calibration.result import FORMAT
from robolaser.data.atomic_write import finish_for_the_dead
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.dataset_file import QUATERNION_SLACK, check_format, inside
from robolaser.errors import DataError, ScanError
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.sensors.stripe import SCANNER, Stripe
from robolaser.parameters import Parameter, Values
from robolaser.robot.kinematics import DOWN, Robot
from robolaser.scan.effects_in_file import effects_in_file
from robolaser.scan.json_object import JsonObject, unusable

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
        stripe_axis: Image axis that the stripe runs along.
        bracket_quat: Nominal turn of the camera on the flange, (x, y, z, w).
        angles: Order of the hand-eye angles.
        image_px: Width and height of its images [px].
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
    stripe_axis: str
    bracket_quat: tuple[float, float, float, float]
    angles: str
    image_px: tuple[int, int]
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
        nominal = {name: np.array([item.nominal]) for name, item in self.parameters.items()}
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
            ("stripe_axis", recording.stripe_axis, self.stripe_axis),
            ("image size", recording.image_px, self.image_px),
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
            bracket_quat=self.bracket_quat,
            angles=self.angles,
        )

    def _posed(self, poses: Poses, robot: Robot | None) -> Poses:
        if robot is None or self.robot is None or poses.q is None:
            return poses
        if set(robot.joints) != set(self.robot.joints):
            raise _of_another_scanner("joints", ", ".join(robot.joints), ", ".join(self.robot.joints))
        order = [robot.joints.index(joint) for joint in self.robot.joints]
        qd = None if poses.qd is None else np.ascontiguousarray(poses.qd[:, order])
        return replace(poses, q=np.ascontiguousarray(poses.q[:, order]), qd=qd)


def _of_another_scanner(what: str, found: object, expected: object) -> ScanError:
    return ScanError(
        f"The recording's {what} is {found}, but the calibration's is {expected}: they belong to different scanners."
        " Use the calibration of the scanner that made the recording, or correct dataset.toml."
    )


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
    file_path = path / FILE if path.is_dir() else path
    if not file_path.exists():
        what = f"has no {FILE}" if path.is_dir() else "does not exist"
        raise DataError(f"{path} {what}. Name the folder that `robolaser calibrate` wrote, or its {FILE}.", file=path)
    path = file_path
    finish_for_the_dead(path.parent)
    file = JsonObject(path, "", read_json(path))
    check_format({"format": file.text("format")}, FORMAT, path.name)
    model, numbers = file.part("model"), file.part("parameters")
    if model.text("sensor") != Stripe.format.kind:
        raise unusable(path, f"its sensor is of kind '{model.text('sensor')}', which sees no stripes")
    robot = _robot(path, model, arm)
    values = {name: np.array([_value(name, numbers.part(name))]) for name in SCANNER}
    candidate_effects = effects_in_file(file.parts("effects"), robot)
    for candidate_effect, part in zip(candidate_effects, file.parts("effects"), strict=True):
        for key in candidate_effect.parameters.names:
            values[key] = np.array([part.part("parameters").part(key.rsplit(".", 1)[-1]).number("value")])
    quat, size = model.numbers("bracket_quat", 4), model.counts("image", 2)
    norm = float(np.linalg.norm(quat))
    if abs(norm - 1) > QUATERNION_SLACK:
        raise unusable(path, f"model.bracket_quat has length {norm:g}, but a rotation has length 1")
    errors = [file.number(key, least=0.0) for key in ("held_out_rms_m", "rms_m") if file.has(key)]
    return Calibrated(
        name=file.text("dataset"),
        origin=f"calibrated from {file.text('dataset')}",
        parameters={name: _parameter(name, numbers.part(name)) for name in SCANNER},
        values=values,
        candidates=candidate_effects,
        robot=robot,
        stripe_axis=model.one_of("stripe_axis", ("u", "v")),
        bracket_quat=(quat[0], quat[1], quat[2], quat[3]),
        angles=model.one_of("angles", ("xyz", "zyz")),
        image_px=(size[0], size[1]),
        noise=_noise(file.part("noise")) if file.has("noise") else {},
        rms_m=errors[0] if errors else None,
        run=_run(file.part("run")) if file.has("run") else None,
    )


def _parameter(name: str, part: JsonObject) -> Parameter:
    unit = Stripe.format.unit_of(name)
    if not part.has("nominal"):
        start = part.number("start")
        return Parameter(name, unit, start, -np.inf, np.inf, given=False)
    nominal, lower, upper = (part.number(key) for key in ("nominal", "lower", "upper"))
    return Parameter(name, unit, nominal, lower, upper)


def _robot(path: Path, model: JsonObject, arm: Robot | None) -> Robot | None:
    if not model.has("robot"):
        return None
    urdf = inside(path.parent, model.text("robot"), f"{path.name}, model.robot")
    return Robot.from_urdf(
        read_text(urdf, ROBOT_BYTES) if arm is None or urdf.exists() else arm.urdf,
        flange=model.text("flange"),
        joints=model.texts("joints") if model.has("joints") else None,
        gravity=model.numbers("gravity", 3) if model.has("gravity") else DOWN,
        source=str(urdf),
    )


def _value(name: str, part: JsonObject) -> float:
    return part.positive("value") if name in Stripe.format.positive else part.number("value")


def _noise(part: JsonObject) -> dict[str, float]:
    return {key: part.number(key, least=0.0) for key in part.keys}


def _run(part: JsonObject) -> RunSummary:
    x, y, z = part.numbers("middle_m", 3)
    low, high = part.numbers("temperature_c", 2) if part.has("temperature_c") else (0.0, 0.0)
    return RunSummary(
        poses=part.count("poses"),
        sha256=part.text("sha256"),
        middle_m=(x, y, z),
        temperature_c=(low, high) if part.has("temperature_c") else None,
    )


def _kind_of_poses(robot: Robot | None) -> str:
    return "measured flange poses" if robot is None else "joint angles"
