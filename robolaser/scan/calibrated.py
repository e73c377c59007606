"""A scanner as a calibration left it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.data.dataset import Dataset, Poses
from robolaser.errors import ScanError
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.sensors.stripe import Stripe
from robolaser.parameters import Parameter, Values
from robolaser.robot.kinematics import Robot


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


def _kind_of_poses(robot: Robot | None) -> str:
    return "measured flange poses" if robot is None else "joint angles"
