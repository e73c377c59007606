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
