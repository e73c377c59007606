"""A xacro file expanded to a URDF by the package xacro, as ROS does it; ROS itself is not needed."""

import contextlib
import io
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from robolaser.errors import RobotError, UsageError
from robolaser.plugins import extra

_UNDEFINED = re.compile(r"Undefined substitution argument (?P<name>\S+)")
MOST_PARENTS = 4  # folders above the file in which a package is sought that the file names by `$(find ...)`


def expanded(path: Path, arguments: Mapping[str, str]) -> str:
    """The URDF of a xacro file.

    `$(find PACKAGE)` is a folder of that name near the file; else whatever an installed ROS says.

    Args:
        path: The xacro file.
        arguments: Of the file, as `xacro FILE NAME:=VALUE` takes them.

    Raises:
        DependencyMissing: The package xacro is not installed.
        RobotError: A package is missing, or the file is no xacro.
        UsageError: An argument is missing.
    """
    missing = f"{path.name} is a xacro file, which needs: pip install 'robolaser[ros]'"
    xacro, substitution_args = extra("xacro", missing), extra("xacro.substitution_args", missing)
    messages = io.StringIO()
    try:
        with contextlib.redirect_stderr(messages), _packages_near(path, substitution_args):
            document: str = xacro.process_file(str(path), mappings=dict(arguments)).toxml()
    except Exception as error:  # whatever the file makes Python do
        text = " ".join(str(error).split()) or type(error).__name__
        if undefined := _UNDEFINED.search(text):
            name = undefined["name"]
            said = f"{path.name} asks for the argument {name}. State it with --xacro-arg {name}=VALUE."
            raise UsageError(said) from None
        raise RobotError(f"{path.name}: xacro does not expand it: {text}") from None
    return document


@contextlib.contextmanager
def _packages_near(path: Path, substitution_args: Any) -> Iterator[None]:
    """Let xacro find packages beside the file; it has no argument for that."""
    installed = substitution_args._eval_find

    def find(package: str) -> str:
        for folder in list(path.resolve().parents)[:MOST_PARENTS]:
            there = folder if folder.name == package else folder / package
            if there.is_dir():
                return str(there)
        try:
            return str(installed(package))
        except Exception:  # whatever ROS raises where it is absent
            raise RobotError(
                f"the package {package} is not there. Put its folder beside the one of {path.name}, or source the ROS"
                " workspace that has it."
            ) from None

    substitution_args._eval_find = find
    substitution_args._eval_dict["find"] = find
    try:
        yield
    finally:
        substitution_args._eval_find = installed
        substitution_args._eval_dict["find"] = installed
