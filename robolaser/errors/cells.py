"""Data that no real cell could have given, or that say too little."""

import difflib
from collections.abc import Iterable
from pathlib import Path

from robolaser.errors.base import RobolaserError, near


class PoseUnknown(RobolaserError):
    """A point's pose is not in poses.csv."""

    def __init__(self, line: int, pose: str, known: Iterable[str]) -> None:
        names = list(known)
        close = difflib.get_close_matches(pose, names, n=1)
        guess = f" Did you mean '{close[0]}'?" if close else ""
        super().__init__(
            f"points.csv, row {line}: no pose '{pose}' in poses.csv, which has {len(names)}.{guess} "
            "Add the pose or delete the row."
        )


class JointOutOfRange(RobolaserError):
    """A joint reading no robot could have made."""

    def __init__(self, line: int, joint: str, value: float, lower: float, upper: float, unit: str) -> None:
        hint = " Are these degrees?" if unit == "rad" else " Are these millimetres?"
        super().__init__(
            f"poses.csv, row {line}: q_{joint} is {value:.4g} {unit}, but the URDF limits {joint} to "
            f"{lower:.2f} .. {upper:.2f} {unit}.{hint}"
        )


class NotAPixel(RobolaserError):
    """A pixel that the image does not have."""

    def __init__(self, line: int, u_px: float, v_px: float, image_px: tuple[int, int]) -> None:
        super().__init__(
            f"points.csv, row {line}: pixel ({u_px:.6g}, {v_px:.6g}) lies outside the image of "
            f"{image_px[0]} x {image_px[1]} pixels. Correct the row, or [image] in dataset.toml."
        )


class TooFar(RobolaserError):
    """A length that looks like another unit."""

    def __init__(self, file: str, line: int, column: str, value: float) -> None:
        super().__init__(
            f"{file}, row {line}, column {column}: {value:.6g} m is farther than any arm reaches. "
            "Are these millimetres? Lengths are metres."
        )


class NotARotation(RobolaserError):
    """A quaternion whose length is not one."""

    def __init__(self, where: str, norm: float) -> None:
        super().__init__(
            f"{where}: the quaternion (x, y, z, w) has length {norm:.4g}, expected 1. "
            "Check the order of its four numbers, or normalise it."
        )


class BoundsWrong(RobolaserError):
    """Bounds that are swapped or exclude the nominal value."""

    def __init__(self, name: str, nominal: float, lower: float, upper: float) -> None:
        why = "lower must be below upper" if not lower < upper else "the nominal value must lie between the bounds"
        super().__init__(
            f"dataset.toml, [parameters] {name}: nominal {nominal:g}, lower {lower:g}, upper {upper:g}; {why}."
        )


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


class NotPositive(RobolaserError):
    """A length of the camera that its bounds let become zero or less."""

    def __init__(self, name: str, lower: float) -> None:
        super().__init__(
            f"dataset.toml, [parameters] {name}: lower is {lower:g}, but focal length and pixel pitches are positive. "
            "Give a lower bound above zero."
        )


class AngleTooLarge(RobolaserError):
    """An angle beyond a full turn."""

    def __init__(self, name: str, value: float) -> None:
        super().__init__(
            f"dataset.toml, [parameters] {name}: {value:g} rad is more than a full turn. Are these degrees?"
        )


class NoPoints(RobolaserError):
    """A recording without points."""

    def __init__(self, folder: Path | None) -> None:
        super().__init__(f"{folder} has no points.csv yet. Run `robolaser extract {folder}` first, or measure points.")


class NothingSeen(RobolaserError):
    """points.csv has no rows."""

    def __init__(self) -> None:
        super().__init__("points.csv has a header but no rows: there is nothing to calibrate from.")
