"""From a calibration and a recording to a cloud of points."""

from dataclasses import dataclass
from typing import final

from robolaser.dataset import Dataset
from robolaser.scan.calibrated import Calibrated, read_calibration
from robolaser.scan.carried import carried_over
from robolaser.scan.cloud import Cloud, arm_scatter
from robolaser.scan.sources import probe, source_of

__all__ = ["Calibrated", "Cloud", "Scan", "prepare", "read_calibration"]


@final
@dataclass(frozen=True)
class Scan:
    """A recording about to be scanned.

    Attributes:
        calibrated: The scanner.
        recording: With the calibrated scanner and its arm.
        cloud: Its points, to be had piece by piece.
        warnings: What the user should know.
    """

    calibrated: Calibrated
    recording: Dataset
    cloud: Cloud
    warnings: tuple[str, ...]

    def comments(self) -> tuple[str, ...]:
        """What the cloud's file says of itself."""
        return (
            f"{self.recording.name}, scanned by robolaser, {self.calibrated.origin}",
            "x y z in the base frame of the robot, in metres",
            "std in metres: how far noise moves a point, root mean square; errors of the calibration are not in it",
            "pose: row of poses.csv, the first is 0; intensity: grey of the stripe, 0 to 255",
        )


def prepare(calibrated: Calibrated, recording: Dataset) -> Scan:
    """Bring scanner and recording together.

    Raises:
        ScannerDiffers: They are not of one scanner.
        NothingToScan: The recording has neither stripes nor points nor images.
        StripesStray, FileUnreadable, StripesForeign: Its stripes.npy is broken.
    """
    fitted = calibrated.fitted_to(recording)
    stated = recording.noise.pixel_px
    source = source_of(fitted, stated if stated is not None else calibrated.noise.get("pixel", float("nan")))
    sight, warnings = carried_over(calibrated, fitted, probe(source, fitted))
    return Scan(calibrated, fitted, Cloud(sight, source, arm_scatter(sight, calibrated)), warnings)
