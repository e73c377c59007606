"""Files that describe a robot in another way than a URDF does, read as the URDF that they amount to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import final

from robolaser.bounded_reading import ROBOT_BYTES, read_text
from robolaser.data.importers.robots.dh_table import read_dh_table
from robolaser.data.importers.robots.mjcf import mjcf_urdf
from robolaser.data.importers.robots.xacro_file import expanded
from robolaser.robot import by_name
from robolaser.robot.kinematics import Robot

_BEGINNING = 4000


@final
@dataclass(frozen=True)
class DescriptionOptions:
    """What the user states about a robot's file beyond its contents."""

    dh: str | None = None  # convention of a table of Denavit-Hartenberg numbers, "standard" or "modified"
    units: tuple[str, ...] = ()  # of its lengths and angles
    xacro: Mapping[str, str] = field(default_factory=dict)  # arguments of a xacro file, by name


def find_robot(
    name_or_path: str | Path,
    *,
    flange: str | None = None,
    joints: Sequence[str] | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
    options: DescriptionOptions | None = None,
) -> Robot:
    """Load a robot by its name or by the path of its description.

    That is a URDF, a xacro file, an MJCF file, or a table of Denavit-Hartenberg numbers as CSV or TOML.

    Args:
        name_or_path: A name of `robolaser list robots`, with or without its maker, or a path.
        flange: The link that carries the sensor. Default: a known robot's own; from a path, the one link
            that carries no other.
        joints: The columns of q. Default: a known robot's own; from a path, or with another flange, all
            that move the flange.
        gravity: In the base frame, (3,) [m/s²].
        options: Information that the file lacks.

    Raises:
        UsageError: Neither a known name nor a file; or information is missing.
        RobotError: A file with several ends, and no flange; or the robot, flange or joints are not usable, see
            `Robot.from_urdf`.
        DataError: The file cannot be read.
        DependencyMissing: The package of the robot or for the file is not installed.

    Examples:
        >>> robolaser.find_robot("ur5e").joints[0]
        'shoulder_pan_joint'
    """
    read = partial(_urdf_of, stated=options or DescriptionOptions())
    return by_name.find_robot(name_or_path, flange=flange, joints=joints, gravity=gravity, read=read)


def _urdf_of(path: Path, stated: DescriptionOptions) -> str:
    if path.suffix in (".csv", ".toml"):
        return read_dh_table(path, stated.dh, stated.units)
    text = read_text(path, ROBOT_BYTES)
    if "<mujoco" in text[:_BEGINNING]:
        return mjcf_urdf(path)
    if path.suffix == ".xacro" or "<xacro:" in text:
        return expanded(path, stated.xacro)
    return text
