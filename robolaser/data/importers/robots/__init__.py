"""Robot descriptions in other formats than URDF, read as an equivalent URDF."""

import contextlib
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, final

from robolaser.bounded_reading import ROBOT_BYTES, read_text
from robolaser.data.importers.robots.dh_table import read_dh_table
from robolaser.data.importers.robots.mjcf import mjcf_urdf
from robolaser.errors import RobotError, UsageError
from robolaser.plugins import extra
from robolaser.robot import by_name
from robolaser.robot.by_name.description import Convention
from robolaser.robot.kinematics import Robot

_BEGINNING = 4000


@final
@dataclass(frozen=True)
class DescriptionOptions:
    """Information of the user that a robot's file lacks."""

    dh: Convention | None = None  # of a table of Denavit-Hartenberg numbers: "standard" or "modified"
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
        return _expanded(path, stated.xacro)
    return text


_UNDEFINED = re.compile(r"Undefined substitution argument (?P<name>\S+)")
MOST_PARENTS = 4  # folders above the file in which a package is sought that the file names by `$(find ...)`


def _expanded(path: Path, arguments: Mapping[str, str]) -> str:
    """The URDF of a xacro file, with arguments as in `xacro FILE NAME:=VALUE`.

    `$(find PACKAGE)` is a folder of that name near the file; else that of an installed ROS.
    """
    missing = f"{path.name} is a xacro file, which needs: pip install 'robolaser[ros]'"
    xacro, substitution_args = extra("xacro", missing), extra("xacro.substitution_args", missing)
    messages = io.StringIO()
    try:
        with contextlib.redirect_stderr(messages), _packages_near(path, substitution_args):
            document: str = xacro.process_file(str(path), mappings=dict(arguments)).toxml()
    except Exception as error:  # xacro evaluates Python
        text = " ".join(str(error).split()) or type(error).__name__
        if undefined := _UNDEFINED.search(text):
            name = undefined["name"]
            message = f"{path.name} asks for the argument {name}. State it with --xacro-arg {name}=VALUE."
            raise UsageError(message) from None
        raise RobotError(f"{path.name}: xacro does not expand it: {text}") from None
    return document


@contextlib.contextmanager
def _packages_near(path: Path, substitution_args: Any) -> Iterator[None]:
    """Let xacro find packages near the file; it has no argument for this."""
    installed = substitution_args._eval_find

    def find(package: str) -> str:
        for folder in list(path.resolve().parents)[:MOST_PARENTS]:
            there = folder if folder.name == package else folder / package
            if there.is_dir():
                return str(there)
        try:
            return str(installed(package))
        except Exception:  # of any type where ROS is absent
            raise RobotError(
                f"the package {package} is missing. Put its folder next to that of {path.name}, or source the ROS"
                " workspace that has it."
            ) from None

    substitution_args._eval_find = find
    substitution_args._eval_dict["find"] = find
    try:
        yield
    finally:
        substitution_args._eval_find = installed
        substitution_args._eval_dict["find"] = installed
