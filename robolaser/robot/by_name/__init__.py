"""Arms that robolaser knows by name: one TOML file each, with rows of numbers from their makers, or the name of a URDF.

Some URDFs come with the optional package example-robot-data (`pip install 'robolaser[robots]'`).
"""

import importlib.metadata
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, final

from robolaser.bounded_reading import ROBOT_BYTES, read_text
from robolaser.errors import DependencyMissing, UsageError, near
from robolaser.robot.by_name.description import Convention, rows_urdf
from robolaser.robot.kinematics import Robot
from robolaser.robot.reading import only_end

_HERE = Path(__file__).parent
SUFFIXES = (".urdf", ".xacro", ".xml", ".csv", ".toml")  # no known robot's name ends so: it is a path
MOST_NAMED = 6


def _read(path: Path) -> str:
    return read_text(path, ROBOT_BYTES)


@final
@dataclass(frozen=True)
class RobotEntry:
    """A robot's TOML file."""

    name: str
    title: str
    maker: str
    aliases: tuple[str, ...]  # common names besides its name and its title
    source: str
    licence: str
    flange: str
    joints: tuple[str, ...]
    urdf: str | None = None
    """Path of the URDF, within the package if one is named, else beside the TOML file; None: it is made of `rows`."""
    package: str | None = None
    base: str = ""  # the first link of a URDF that is made of rows
    convention: Convention = "standard"  # of the rows, see `rows_urdf`
    rows: tuple[dict[str, Any], ...] = ()
    controller: Mapping[str, Any] = field(default_factory=dict)
    """`[arm]` of a cell for its controller; empty: there is no driver."""

    @property
    def names(self) -> tuple[str, ...]:
        """All its names."""
        return self.name, self.title, *self.aliases

    def text(self) -> str:
        """Its URDF.

        Raises:
            DependencyMissing: The package that brings it is absent, or is a version without this robot.
        """
        if self.urdf is not None:
            return _read(self.path())
        return rows_urdf(self.rows, self.convention, self.name, self.base, self.flange)

    def path(self) -> Path:
        """Path of the URDF, or of the table of rows.

        Raises:
            DependencyMissing: The package that brings it is absent, or is a version without this robot.
        """
        if self.package is None or self.urdf is None:
            return _HERE / (self.urdf or f"{self.name}.toml")
        for folder in _folders(self.package):
            if (folder / self.urdf).is_file():
                return folder / self.urdf
        raise DependencyMissing(
            f"Robot '{self.name}' needs {self.urdf} of the package {self.package}, which is not there:"
            " pip install --upgrade 'robolaser[robots]'"
        )


def known_robots() -> list[RobotEntry]:
    """All robots with a file here, by name, including those of packages that are not installed."""
    return [_entry(file) for file in sorted(_HERE.glob("*.toml"))]


def find_robot(
    name_or_path: str | Path,
    *,
    flange: str | None = None,
    joints: Sequence[str] | None = None,
    gravity: Sequence[float] = (0.0, 0.0, -9.81),
    read: Callable[[Path], str] = _read,
) -> Robot:
    """Load a robot by its name here or by the path of its URDF, as `robolaser.find_robot` does, which reads more.

    `read` gives a file as the text of a URDF.

    Examples:
        >>> find_robot("ur5e").joints[0]
        'shoulder_pan_joint'
    """
    path = Path(name_or_path)
    is_path = path.suffix in SUFFIXES or path.is_file()
    entry = None if is_path else named(str(name_or_path))
    if entry is not None:
        text, source = entry.text(), entry.path().name
        if flange is None:
            flange, joints = entry.flange, joints or entry.joints
    elif is_path:
        text, source = read(path), path.name
    else:
        raise UsageError(f"{_unknown(str(name_or_path))} Or give the path of a .urdf file.")
    if flange is None:
        flange = only_end(text, source)
    return Robot.from_urdf(text, flange=flange, joints=joints, gravity=gravity, source=source)


def named(name: str) -> RobotEntry | None:
    """The known robot of this name; None where there is none."""
    entries = known_robots()
    for spelled in (_plain(name), _without_maker(name, entries)):
        for entry in entries:
            if spelled in map(_plain, entry.names):
                return entry
    return None


def entry_of(name: str) -> RobotEntry:
    """The known robot of this name.

    Raises:
        UsageError: There is none.
    """
    entry = named(name)
    if entry is None:
        raise UsageError(_unknown(name))
    return entry


def _unknown(name: str) -> str:
    return f"No robot '{name}'.{near(name, (entry.name for entry in known_robots()), MOST_NAMED)}"


def _plain(name: str) -> str:
    """A name without blanks, dashes, slashes and capitals: "KR 6 R900-sixx" -> "kr6r900sixx"."""
    return re.sub(r"[^a-z0-9]", "", name.casefold())


def _without_maker(name: str, entries: Iterable[RobotEntry]) -> str:
    """A plain name without the maker of one of some robots: "Universal Robots UR5e" -> "ur5e"."""
    spoken = {word for entry in entries for word in entry.maker.casefold().split()}
    return "".join(word for word in re.findall(r"[a-z0-9]+", name.casefold()) if word not in spoken)


@lru_cache
def _entry(file: Path) -> RobotEntry:
    contents = tomllib.loads(file.read_text(encoding="utf-8"))
    rows = tuple(contents.pop("rows", ()))
    joints = contents.pop("joints", [row["joint"] for row in rows if "joint" in row])
    aliases = tuple(contents.pop("aliases", ()))
    return RobotEntry(name=file.stem, joints=tuple(joints), aliases=aliases, rows=rows, **contents)


def _folders(package: str) -> list[Path]:
    """The folder of a package of robots: as a wheel, or under the prefix (conda, robotpkg)."""
    folders = [Path(sys.prefix) / "share" / package / "robots"]
    try:
        wheel = importlib.metadata.distribution(package)
    except importlib.metadata.PackageNotFoundError:
        return folders
    return [Path(str(wheel.locate_file(f"cmeel.prefix/share/{package}/robots"))), *folders]
