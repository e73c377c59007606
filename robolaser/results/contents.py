"""The contents of the files of a calibration or a diagnosis."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, NotRequired, TypedDict

import msgspec

from robolaser.bounded_reading import ROBOT_BYTES, read_json, read_text
from robolaser.calibration.result import FORMAT as CALIBRATION
from robolaser.diagnosis.result_json import FORMAT as DIAGNOSIS
from robolaser.errors import DataError
from robolaser.robot.kinematics import DOWN, Robot


class _Number(TypedDict):
    value: float | None
    std: float | None


class _Effect(TypedDict):
    effect: str
    where: str
    parameters: dict[str, _Number]


class _Model(TypedDict, total=False):
    robot: str | None
    flange: str | None
    joints: list[str] | None
    gravity: list[float] | None


class _Read(TypedDict):
    """The entries that are read of both."""

    effects: list[_Effect]
    parameters: NotRequired[dict[str, _Number]]
    model: NotRequired[_Model]


FILES: Final = {CALIBRATION: "calibration.json", DIAGNOSIS: "diagnosis.json"}


def read_result(path: Path, *formats: str) -> tuple[dict[str, Any], Path | None]:
    """The contents of a result's JSON file, given itself or its folder, and that folder.

    A JSON file under another name is alone: files beside it may be those of another result.

    Args:
        path: The file or folder.
        formats: Accepted formats; default: calibration or diagnosis.

    Raises:
        DataError: It cannot be read, or is of another format.
    """
    known = formats or tuple(FILES)
    names = [FILES[one] for one in known]
    there = [path / name for name in names if (path / name).is_file()] if path.is_dir() else [path]
    if not there:
        raise DataError(f"{path} holds no {' and no '.join(names)}.", file=path)
    file = there[-1]  # of a diagnosis, which has both
    contents = read_json(file)
    found = contents.get("format") if isinstance(contents, dict) else None
    if found not in known:
        raise DataError(f"{file}: expected the format {' or '.join(known)}, not {found!r}.", file=file.name)
    try:
        msgspec.convert(contents, _Read)
    except msgspec.ValidationError as error:
        raise DataError(f"{file}: {error}. Is the file complete?", file=file.name) from None
    return contents, file.parent if file.name in FILES.values() else None


def robot_in(folder: Path | None) -> Robot | None:
    """The corrected arm of a saved result; None for flange poses, moving arms, and without a URDF in its folder.

    Raises:
        DataError: The folder's files cannot be read.
        RobotError: The URDF has no such flange or joints.
    """
    contents = _calibration_in(folder)
    model = contents.get("model", {})
    if folder is None or not model.get("robot") or contents.get("kind") == "motion":
        return None
    names = ("robot_corrected.urdf", model["robot"])
    file = next((folder / name for name in names if (folder / name).is_file()), None)
    if file is None:
        return None
    placed = {"flange": model.get("flange", ""), "joints": model.get("joints"), "gravity": model.get("gravity") or DOWN}
    return Robot.from_urdf(read_text(file, ROBOT_BYTES), **placed, source=file.name)


def run_in(folder: Path | None) -> dict[str, Any]:
    """The run of calibration.json in a folder, also that of a diagnosis beside it."""
    contents = _calibration_in(folder)
    return {"run": contents.get("run")} if contents else {}


def _calibration_in(folder: Path | None) -> dict[str, Any]:
    """The contents of calibration.json in a folder; none where there is none."""
    if folder is None or not (folder / FILES[CALIBRATION]).is_file():
        return {}
    return read_result(folder, CALIBRATION)[0]


def numbers_of(contents: Mapping[str, Any]) -> dict[str, Any]:
    """The entry of each parameter in a calibration or a diagnosis, of effects as `EFFECT.WHERE.PARAMETER`."""
    of_effects = {
        f"{one['effect']}.{one['where']}.{name}": number
        for one in contents["effects"]
        for name, number in one["parameters"].items()
    }
    return {**contents.get("parameters", {}), **of_effects}
