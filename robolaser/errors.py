"""Errors that a program may catch, and messages that several files use."""

import difflib
import operator
from collections.abc import Iterable
from pathlib import Path


class RobolaserError(Exception):
    """The data, the robot or a file is at fault; the message is for a person.

    Examples:
        >>> try:
        ...     robolaser.load("nowhere")
        ... except robolaser.RobolaserError as error:
        ...     print(type(error).__name__)
        DataError
    """


class UsageError(RobolaserError):
    """The arguments have no meaning, whatever the data."""


class DataError(RobolaserError):
    """A file, row or cell does not conform to the data format.

    Attributes:
        file: The file, if known.
        row: Its row, counted from 1, the header's.
        column: The column or key.
    """

    def __init__(
        self, message: str, *, file: str | Path | None = None, row: int | None = None, column: str | None = None
    ) -> None:
        super().__init__(message)
        self.file, self.row, self.column = file, row, column


class OutputError(RobolaserError):
    """A result cannot be written, or would overwrite another one."""


class RobotError(RobolaserError):
    """A robot, its URDF or its joints are not usable."""


class EffectError(RobolaserError):
    """An effect is unknown, has no such location, or cannot be tested with these data."""


class EstimationError(RobolaserError):
    """Parameters cannot be found from these data."""


class AlgorithmError(RobolaserError):
    """An algorithm, an operator or one of their settings is unknown or makes no sense."""


class BenchmarkError(RobolaserError):
    """Algorithms cannot be compared as requested."""


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
    """It was stopped, by the user or by a failure; the message states where earlier work is kept."""


def check_seed(seed: int) -> None:
    """Refuse what NumPy's generators would not take.

    Raises:
        UsageError: A seed is no whole number, or negative.
    """
    try:
        is_seed = operator.index(seed) >= 0
    except TypeError:
        is_seed = False
    if not is_seed:
        raise UsageError(f"seed is {seed!r}, expected a whole number of at least 0.")


def near(name: str, known: Iterable[str], most: int | None = None) -> str:
    """Suggest the nearest of the known names: " Did you mean 'tool0'? There are: base, tool0.".

    Args:
        name: The given name.
        known: The known names.
        most: How many are listed, the nearest; None: all.
    """
    names = list(known)
    few = names if most is None or len(names) <= most else difflib.get_close_matches(name[:100], names, most, 0.0)
    more = f", and {len(names) - len(few)} more" if len(few) < len(names) else ""
    return f"{meant(name[:100], names)} There are: {', '.join(few) if few else 'none'}{more}."


def meant(name: str, known: Iterable[str]) -> str:
    """Suggest the nearest name, if there is one: " Did you mean 'tool0'?"."""
    names = {known_name.casefold(): known_name for known_name in known}
    close = difflib.get_close_matches(name.casefold(), names, n=1)
    return f" Did you mean '{names[close[0]]}'?" if close else ""


def unreadable(path: Path, reason: str) -> DataError:
    """The error of a file that is missing or not what it should be."""
    return DataError(f"Cannot read {path}: {reason}.", file=path)


def unwritable(path: Path, reason: str) -> OutputError:
    """The error of a file that the disk or its rights refuse."""
    return OutputError(
        f"Cannot write {path}: {reason}. What was there before is unchanged; make room or choose another folder."
    )


def output_exists(path: Path) -> OutputError:
    """The error of a result that would be overwritten."""
    return OutputError(f"{path} holds a result already. Choose another --output, or overwrite it with --force.")
