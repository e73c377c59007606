"""Arms that robolaser knows by name: one TOML file each, which names a URDF, its flange and its joints.

Most URDFs come with the optional package example-robot-data (`pip install 'robolaser[robots]'`).
"""

import importlib.metadata
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from robolaser.errors import DependencyMissing, RobotError, UsageError, near
from robolaser.geometry import urdf
from robolaser.geometry.kinematics import Robot
from robolaser.geometry.urdf.tree import MOST_LISTED

_HERE = Path(__file__).parent


@final
@dataclass(frozen=True)
class RobotEntry:
    """What a robot's TOML file says."""

    name: str
    title: str
    source: str
    licence: str
    urdf: str
    """Path of the URDF, within the package if one is named, else beside the TOML file."""
    flange: str
    joints: tuple[str, ...]
    package: str | None = None

    def path(self) -> Path:
        """Where the URDF lies.

        Raises:
            DependencyMissing: The package that brings it is absent, or is a version without this robot.
        """
        if self.package is None:
            return _HERE / self.urdf
        for folder in _folders(self.package):
            if (folder / self.urdf).is_file():
                return folder / self.urdf
        raise DependencyMissing(
            f"Robot '{self.name}' needs {self.urdf} of the package {self.package}, which is not there:"
            " pip install --upgrade 'robolaser[robots]'"
        )


def known_robots() -> list[RobotEntry]:
    """All robots with a file here, by name; those of packages that are not installed too."""
    return [_entry(file) for file in sorted(_HERE.glob("*.toml"))]


def find_robot(
    name_or_path: str | Path,
    *,
    flange: str | None = None,
    joints: Sequence[str] | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
    options: urdf.DescriptionOptions | None = None,
) -> Robot:
    """Load a robot by its name here or by the path of its description.

    That is a URDF, a xacro file, an MJCF file, or a table of Denavit-Hartenberg numbers as CSV or TOML.

    Args:
        name_or_path: A name of `known_robots`, else a path.
        flange: The link that carries the sensor. When absent, a known robot's own; from a path, the one link
            that carries no other.
        joints: The columns of q. When absent, a known robot's own; from a path, or with another flange, all
            that move the flange.
        gravity: In the base frame, (3,) [m/s²].
        options: What a person says of a file that it does not say.

    Raises:
        UsageError: Neither a known name nor a file.
        RobotError: A URDF with several ends, and no flange; or its URDF, flange or joints are not usable, see
            `Robot.from_urdf`.
        DataError: The path leads to no file that can be read.
        DependencyMissing: Known, but its package is absent.
    """
    toml = _HERE / f"{name_or_path}.toml"
    if Path(name_or_path).name == str(name_or_path) and toml.is_file():
        entry = _entry(toml)
        path = entry.path()
        if flange is None:
            flange, joints = entry.flange, joints or entry.joints
    else:
        path = Path(name_or_path)
        if path.suffix not in urdf.SUFFIXES and not path.is_file():
            known = [file.stem for file in sorted(_HERE.glob("*.toml"))]
            raise UsageError(
                f"No robot '{name_or_path}'.{near(str(name_or_path), known)} Or give the path of a .urdf file."
            )
    text = urdf.load_description(path, options)
    if flange is None:
        leaves = urdf.parse(text, source=path.name).leaves()
        if len(leaves) != 1:
            more = f", and {len(leaves) - MOST_LISTED} more" if len(leaves) > MOST_LISTED else ""
            raise RobotError(
                f"{path.name} has {len(leaves)} ends: {', '.join(leaves[:MOST_LISTED])}{more}."
                " State which link is the flange."
            )
        flange = leaves[0]
    return Robot.from_urdf(text, flange=flange, joints=joints, gravity=gravity, source=path.name)


def _entry(file: Path) -> RobotEntry:
    said = tomllib.loads(file.read_text(encoding="utf-8"))
    return RobotEntry(
        name=file.stem,
        title=said["title"],
        source=said["source"],
        licence=said["licence"],
        urdf=said["urdf"],
        flange=said["flange"],
        joints=tuple(said["joints"]),
        package=said.get("package"),
    )


def _folders(package: str) -> list[Path]:
    """Where a package of robots keeps them: as a wheel, or under the prefix (conda, robotpkg)."""
    folders = [Path(sys.prefix) / "share" / package / "robots"]
    try:
        wheel = importlib.metadata.distribution(package)
    except importlib.metadata.PackageNotFoundError:
        return folders
    return [Path(str(wheel.locate_file(f"cmeel.prefix/share/{package}/robots"))), *folders]
