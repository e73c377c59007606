"""What a program may want to catch; the sentence is written where an error is raised."""

from pathlib import Path

from robolaser.errors.base import RobolaserError, WrongUsage

UsageError = WrongUsage


class DataError(RobolaserError):
    """A file, row or cell is not what the data format asks for.

    Attributes:
        file: Which file, if it is known.
        row: Which row of it, counted from 1, the header's.
        column: Which column or key.
    """

    def __init__(
        self, message: str, *, file: str | Path | None = None, row: int | None = None, column: str | None = None
    ) -> None:
        super().__init__(message)
        self.file, self.row, self.column = file, row, column


class OutputError(RobolaserError):
    """A result cannot be written, or would overwrite what is there."""


class RobotError(RobolaserError):
    """A robot, its URDF or its joints are not usable."""


class EffectError(RobolaserError):
    """An effect is unknown, has no such location, or cannot be tested with these data."""


class EstimationError(RobolaserError):
    """Parameters cannot be found from these data."""


class AlgorithmError(RobolaserError):
    """An algorithm, an operator or one of their settings is unknown or makes no sense."""


class BenchmarkError(RobolaserError):
    """Algorithms cannot be compared as asked."""


class TrialError(RobolaserError):
    """A blind trial cannot be made, read or scored."""


class ImageError(RobolaserError):
    """An image or a camera's recording cannot be used."""


class CameraError(RobolaserError):
    """A camera cannot be reached, or gives no usable image."""


class PlanError(RobolaserError):
    """A motion plan is not safe, or does not fit the cell."""


class ArmError(RobolaserError):
    """An arm refuses, raises an alarm, or is not where it should be."""


class LineLost(ArmError):
    """The line to the arm is silent or gone."""


class ScanError(RobolaserError):
    """A point cloud cannot be made or measured."""


class DependencyMissing(RobolaserError):
    """An optional package is not installed."""


class PluginError(RobolaserError):
    """An installed package announces something that cannot be used."""


class Interrupted(RobolaserError):
    """It was stopped, by the user or by a failure; what was done so far is kept where the message says."""
