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

from robolaser.errors import FlangeNotSaid, RobotNotInstalled, RobotUnknown
from robolaser.geometry import urdf
from robolaser.geometry.kinematics import Robot

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
            RobotNotInstalled: The package that brings it is absent, or is a version without this robot.
        """
        if self.package is None:
            return _HERE / self.urdf
        for folder in _folders(self.package):
            if (folder / self.urdf).is_file():
                return folder / self.urdf
        raise RobotNotInstalled(self.name, self.package, self.urdf)


def known_robots() -> list[RobotEntry]:
    """All robots with a file here, by name; those of packages that are not installed too."""
    return [_entry(file) for file in sorted(_HERE.glob("*.toml"))]


def find_robot(
    name_or_path: str | Path,
    *,
    flange: str | None = None,
    joints: Sequence[str] | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
) -> Robot:
    """Load a robot by its name here or by the path of its URDF.

    Args:
        name_or_path: A name of `known_robots`, else a path.
        flange: The link that carries the sensor. When absent, a known robot's own; from a path, the one link
            that carries no other.
        joints: The columns of q. When absent, a known robot's own; from a path, or with another flange, all
            that move the flange.
        gravity: In the base frame, (3,) [m/s²].

    Raises:
        RobotUnknown: Neither a known name nor a file.
        DataError: The path leads to no file that can be read.
        RobotNotInstalled: Known, but its package is absent.
        FlangeNotSaid: A path to a URDF with several ends, and no flange.
        RobolaserError: The URDF, the flange or the joints are wrong, see `Robot.from_urdf`.
    """
    toml = _HERE / f"{name_or_path}.toml"
    if Path(name_or_path).name == str(name_or_path) and toml.is_file():
        entry = _entry(toml)
        path = entry.path()
        if flange is None:
            flange, joints = entry.flange, joints or entry.joints
    else:
        path = Path(name_or_path)
        if path.suffix != ".urdf" and not path.is_file():
            raise RobotUnknown(str(name_or_path), [file.stem for file in sorted(_HERE.glob("*.toml"))])
    text = urdf.load_text(path)
    if flange is None:
        leaves = urdf.parse(text, source=path.name).leaves()
        if len(leaves) != 1:
            raise FlangeNotSaid(path.name, leaves)
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
