"""Files that describe a robot in another way than a URDF does, as the URDF that they amount to."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

from robolaser.geometry.urdf.dh_table import DHStatement, read_dh_table
from robolaser.geometry.urdf.mjcf import mjcf_urdf
from robolaser.geometry.urdf.parsing import load_text
from robolaser.geometry.urdf.xacro_file import expanded

SUFFIXES = (".urdf", ".xacro", ".xml", ".csv", ".toml")
_BEGINNING = 4000


@final
@dataclass(frozen=True)
class DescriptionOptions:
    """What a person says of a robot's file that it does not say."""

    dh: DHStatement = DHStatement()  # the convention and the units of a table of Denavit-Hartenberg numbers
    xacro: Mapping[str, str] = field(default_factory=dict)  # arguments of a xacro file, by name


def load_description(path: Path, options: DescriptionOptions | None = None) -> str:
    """A robot's file as a URDF: a URDF itself, a xacro file, an MJCF file, or a table of Denavit-Hartenberg numbers.

    Raises:
        RobotError: The file is not what it seems to be.
        UsageError: It leaves open what no option says.
        DataError: It cannot be read.
        DependencyMissing: A package that reads it is not installed.
    """
    stated = options or DescriptionOptions()
    if path.suffix in (".csv", ".toml"):
        return read_dh_table(path, stated.dh)
    text = load_text(path)
    if "<mujoco" in text[:_BEGINNING]:
        return mjcf_urdf(path)
    if path.suffix == ".xacro" or "<xacro:" in text:
        return expanded(path, stated.xacro)
    return text
