"""A xacro file expanded to a URDF by the package xacro, as ROS does it; ROS itself is not needed."""

import contextlib
import io
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from robolaser.errors import DependencyMissing, RobotError, UsageError

_UNDEFINED = re.compile(r"Undefined substitution argument (?P<name>\S+)")
_NAME = re.compile(r"<name>\s*(\S+?)\s*</name>")
MOST_PARENTS = 4  # folders above the file in which a package is sought that the file names by `$(find ...)`


def expanded(path: Path, arguments: Mapping[str, str]) -> str:
    """The URDF of a xacro file.

    `$(find PACKAGE)` is a folder of that name, or with a package.xml of that name, near the file; else whatever an
    installed ROS says.

    Args:
        path: The xacro file.
        arguments: Of the file, as `xacro FILE NAME:=VALUE` takes them.

    Raises:
        DependencyMissing: The package xacro is not installed.
        RobotError: A package is missing, or the file is no xacro.
        UsageError: An argument is missing.
    """
    try:
        import xacro  # noqa: PLC0415 - an extra
        from xacro import substitution_args  # noqa: PLC0415
    except ImportError:
        raise DependencyMissing(f"{path.name} is a xacro file, which needs: pip install 'robolaser[ros]'") from None
    messages = io.StringIO()
    try:
        with contextlib.redirect_stderr(messages), _packages_near(path, substitution_args):
            document: str = xacro.process_file(str(path), mappings=dict(arguments)).toxml()
    except Exception as error:  # whatever the file makes Python do
        raise _reason(path, error) from None
    return document


def _reason(path: Path, error: Exception) -> RobotError | UsageError:
    text = " ".join(str(error).split()) or type(error).__name__
    undefined = _UNDEFINED.search(text)
    if undefined:
        name = undefined["name"]
        return UsageError(f"{path.name} asks for the argument {name}. State it with --xacro-arg {name}=VALUE.")
    return RobotError(f"{path.name}: xacro does not expand it: {text}")


@contextlib.contextmanager
def _packages_near(path: Path, substitution_args: Any) -> Iterator[None]:
    """Let xacro find packages beside the file; it has no argument for that."""
    installed = substitution_args._eval_find

    def find(package: str) -> str:
        folder = package_near(path, package)
        if folder is not None:
            return str(folder)
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


def package_near(path: Path, package: str) -> Path | None:
    """The folder of a ROS package that holds the file, or lies beside one that does; None where there is none."""
    for folder in list(path.resolve().parents)[:MOST_PARENTS]:
        if folder.name == package or _named(folder) == package:
            return folder
        beside = folder / package
        if beside.is_dir():
            return beside
    return None


def _named(folder: Path) -> str | None:
    """The name that a package.xml states."""
    try:
        found = _NAME.search((folder / "package.xml").read_text("utf-8", "replace"))
    except OSError:
        return None
    return None if found is None else found[1]
