"""Calibrations that cannot be used, recordings that hold no surface, clouds that cannot be shown."""

from collections.abc import Iterable
from pathlib import Path

from robolaser.errors.base import RobolaserError, near


class CalibrationUnreadable(RobolaserError):
    """A file that is no calibration of a scanner."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(
            f"Cannot use {path}: {reason}. Expected calibration.json of a stripe scanner as `robolaser calibrate`"
            " or `robolaser diagnose` writes it, robot.urdf beside it."
        )


class EffectForeign(RobolaserError):
    """A calibration holds an effect that is not installed here."""

    def __init__(self, path: Path, name: str, known: Iterable[str]) -> None:
        super().__init__(
            f"{path} has the effect '{name}' in its model, which is not known here.{near(name, known)} Install the"
            " package that brings it, or calibrate anew without it."
        )


class ScannerDiffers(RobolaserError):
    """A recording that was not made with the calibrated scanner."""

    def __init__(self, what: str, found: object, expected: object) -> None:
        super().__init__(
            f"The recording's {what} is {found}, but the calibration's is {expected}: they are not of one scanner. Take"
            " the calibration of the scanner that recorded, or correct dataset.toml."
        )


class NothingToScan(RobolaserError):
    """A recording without stripes, points or images."""

    def __init__(self, folder: Path | None) -> None:
        super().__init__(
            f"{folder} has neither stripes.npy nor points.csv nor images named in poses.csv: there is nothing to scan."
            " Record images, or run `robolaser extract` on them."
        )


class NoMiddles(RobolaserError):
    """A recording in which nobody saw a stripe."""

    def __init__(self, source: str) -> None:
        super().__init__(
            f"No image shows a stripe: there is no middle of one in {source}. Check that the laser was on, the"
            " exposure, and [sensor] stripe_axis; then record again, or run `robolaser extract --force`."
        )


class StripesStray(RobolaserError):
    """Stripes of poses that the recording does not have."""

    def __init__(self, folder: Path | None, pose: int, poses: int) -> None:
        super().__init__(
            f"stripes.npy of {folder} has middles of row {pose} of poses.csv, which has {poses} rows from 0 to"
            f" {poses - 1}. They are not of one recording: run `robolaser extract --force` again."
        )


class NothingMet(RobolaserError):
    """No ray met the light sheet in front of the camera."""

    def __init__(self, middles: int) -> None:
        super().__init__(
            f"Of {middles} middles of the stripe none lies where a ray meets the light sheet in front of the camera."
            " Check that calibration and recording are of one scanner, and stripe_axis."
        )


class SolidNotFound(RobolaserError):
    """A body of known size that is not in the cloud."""

    def __init__(self, what: str, reason: str) -> None:
        super().__init__(
            f"No {what} found in the cloud: {reason}. The cloud itself is written; leave the option out if nothing of"
            " the kind was scanned."
        )


class CloudUnreadable(RobolaserError):
    """A file that is no cloud of ours."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"Cannot show {path}: {reason}. Expected a cloud as `robolaser scan` writes it.")


class ViserMissing(RobolaserError):
    """What draws in the browser is not installed."""

    def __init__(self) -> None:
        super().__init__("viser is not installed, which shows the scene: pip install 'robolaser[view]'.")


class PortTaken(RobolaserError):
    """Nobody can listen at that port."""

    def __init__(self, port: int, reason: str) -> None:
        super().__init__(f"Cannot serve at port {port}: {reason}. Choose another --port.")
