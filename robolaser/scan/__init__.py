"""From a calibration and a recording to a cloud of points."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

from robolaser.data.dataset import Dataset
from robolaser.scan.calibrated import Calibrated, read_calibration
from robolaser.scan.cloud import Cloud, ScannedRecording, arm_scatter, sample_points, source_of
from robolaser.scan.scanner_model import carried_over

__all__ = ["Calibrated", "Cloud", "Scan", "merged", "prepare", "read_calibration"]


@final
@dataclass(frozen=True)
class Scan:
    """A prepared scan of a recording.

    Attributes:
        calibrated: The scanner.
        recording: With the calibrated scanner and its arm.
        cloud: Its points, in pieces.
        warnings: Warnings for the user.

    Examples:
        >>> scan.recording.name
        'paper'
    """

    calibrated: Calibrated
    recording: Dataset
    cloud: Cloud
    warnings: tuple[str, ...]

    def comments(self) -> tuple[str, ...]:
        """Comments for the cloud's file."""
        return (
            f"{self.recording.name}, scanned by robolaser, {self.calibrated.origin}",
            "x y z in the base frame of the robot, in metres",
            "std in metres: standard deviation of a point by noise, root mean square, by the calibration's noise model",
            "errors of its model count as noise of the joints; errors common to all points are not included",
            "pose: row of poses.csv, the first is 0; further recordings are numbered consecutively",
            "intensity: grey of the stripe, 0 to 255",
        )


def prepare(calibrated: Calibrated, recording: Dataset) -> Scan:
    """Prepare the scan of a recording.

    Raises:
        ScanError: They are of different scanners, or the recording has nothing to scan.
        DataError: The image columns of its poses.csv are invalid, or its stripes.npy is broken.

    Examples:
        >>> prepare(read_calibration("scanner"), dataset).warnings
        ()
    """
    fitted = calibrated.fitted_to(recording)
    stated = recording.noise.pixel_px
    source = source_of(fitted, stated if stated is not None else calibrated.noise.get("pixel", float("nan")))
    scanner, notes = carried_over(calibrated, fitted, sample_points(source, fitted))
    scanned = ScannedRecording(scanner, source, arm_scatter(scanner, calibrated))
    return Scan(calibrated, fitted, Cloud((scanned,)), notes)


def merged(scans: Sequence[Scan]) -> Scan:
    """Merge scans with one calibration.

    Examples:
        >>> merged([scan, scan]).recording.name
        'paper, paper'
    """
    first = scans[0]
    if len(scans) == 1:
        return first
    cloud = Cloud(tuple(part for scan in scans for part in scan.cloud.parts))
    recording = replace(first.recording, name=", ".join(scan.recording.name for scan in scans))
    warnings = tuple(dict.fromkeys(warning for scan in scans for warning in scan.warnings))
    return replace(first, recording=recording, cloud=cloud, warnings=warnings)
