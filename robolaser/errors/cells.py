"""Data that no real cell could have given, or that say too little."""

from collections.abc import Iterable
from pathlib import Path

from robolaser.errors.base import RobolaserError, near


class ParameterMissing(RobolaserError):
    """A parameter that this kind of sensor needs is not given."""

    def __init__(self, missing: Iterable[str], kind: str) -> None:
        super().__init__(
            f"dataset.toml, [parameters] lacks {', '.join(missing)}: a {kind} sensor needs "
            "{ nominal, lower, upper } for each."
        )


class ParameterUnknown(RobolaserError):
    """A parameter that this kind of sensor does not have."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        super().__init__(f"dataset.toml, [parameters]: no parameter '{name}' here.{near(name, known)}")


class NoPoints(RobolaserError):
    """A recording without points."""

    def __init__(self, folder: Path | None) -> None:
        super().__init__(f"{folder} has no points.csv yet. Run `robolaser extract {folder}` first, or measure points.")


class NothingSeen(RobolaserError):
    """points.csv has no rows."""

    def __init__(self) -> None:
        super().__init__("points.csv has a header but no rows: there is nothing to calibrate from.")


class TargetUnseen(RobolaserError):
    """The camera cannot have seen the target where the data set says it is."""

    def __init__(self, line: int, pose: str, behind: int, rows: int) -> None:
        super().__init__(
            f"points.csv, row {line} (pose {pose}): with the nominal parameters the target point lies behind the "
            f"camera, as do {behind} of {rows} rows. Check the target's frame and units, bracket_quat and the flange."
        )


class TooFewPoses(RobolaserError):
    """Not enough poses for the parameters asked for."""

    def __init__(self, poses: int, different: int, needed: int, parameters: int) -> None:
        differing = f", of which only {different} differ{'s' if different == 1 else ''}," if different < poses else ""
        super().__init__(
            f"{poses} pose{'s' if poses != 1 else ''} with points{differing} cannot fix {parameters} parameters: "
            f"at least {needed} are needed. Measure more poses, turned and tilted against each other."
        )
