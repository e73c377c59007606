"""Saved results: the entries of calibration.json and diagnosis.json that are read, and the arm beside them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, final

from robolaser.bounded_reading import ROBOT_BYTES, read_json, read_text
from robolaser.data.dataset_file import Pixels
from robolaser.data.toml_schema import typed
from robolaser.errors import DataError
from robolaser.model.effects.run import RunSummary
from robolaser.robot.kinematics import DOWN, Robot

CALIBRATION: Final = "robolaser-calibration/1"
DIAGNOSIS: Final = "robolaser-diagnosis/1"
FILES: Final = {CALIBRATION: "calibration.json", DIAGNOSIS: "diagnosis.json"}


@final
@dataclass(frozen=True)
class SavedNumber:
    """An estimated number; a sensor's also with nominal value and bounds, or, without these, with its start value."""

    value: float
    std: float | None
    nominal: float | None = None
    lower: float | None = None
    upper: float | None = None
    start: float | None = None


@final
@dataclass(frozen=True)
class SavedEffect:
    """An effect at a location."""

    effect: str
    where: str
    parameters: dict[str, SavedNumber]


@dataclass(frozen=True, kw_only=True)
class SavedModel:
    """`model` of a calibration: no arm where flange poses were measured."""

    sensor: str = ""
    robot: str | None = None
    flange: str | None = None
    joints: tuple[str, ...] | None = None
    gravity: tuple[float, float, float] | None = None
    image: tuple[Pixels, Pixels] | None = None  # width and height [px]

    def arm(self, urdf: str, source: Path) -> Robot:
        """Its arm by a URDF.

        Raises:
            RobotError: The URDF has no such flange or joints.
        """
        gravity = self.gravity or DOWN
        return Robot.from_urdf(urdf, flange=self.flange or "", joints=self.joints, gravity=gravity, source=str(source))


@dataclass(frozen=True, kw_only=True)
class SavedResult:
    """The entries of a calibration or a diagnosis that are read of any."""

    effects: tuple[SavedEffect, ...]
    kind: str = ""
    parameters: dict[str, SavedNumber] = field(default_factory=dict)
    model: SavedModel = SavedModel()
    run: RunSummary | None = None


def read_result(path: Path, *formats: str) -> tuple[dict[str, Any], SavedResult, Path | None]:
    """The contents of a result's JSON file, given itself or its folder; its checked entries, and that folder.

    A JSON file under another name is alone: files beside it may be those of another result.

    Args:
        path: The file or folder.
        formats: Accepted formats; default: calibration or diagnosis.

    Raises:
        DataError: It cannot be read, is of another format, or an entry is missing or invalid.
    """
    known = formats or tuple(FILES)
    names = [FILES[one] for one in known]
    there = [path / name for name in names if (path / name).is_file()] if path.is_dir() else [path] * path.exists()
    if not there:
        which = "that `robolaser calibrate` or `robolaser diagnose` wrote, or its JSON file"
        raise DataError(f"There is no {' and no '.join(names)} at {path}. Name a folder {which}.", file=path)
    file = there[-1]  # of a diagnosis, which has both
    contents = read_json(file)
    found = contents.get("format") if isinstance(contents, dict) else None
    if found not in known:
        raise DataError(f"{file}: expected the format {' or '.join(known)}, not {found!r}.", file=file.name)
    entries = typed(contents, SavedResult, file=str(file), others=True)
    return contents, entries, file.parent if file.name in FILES.values() else None


def robot_in(folder: Path | None, *, nominal: bool = False) -> Robot | None:
    """The corrected arm of a saved result, or the nominal one; None for flange poses, moving arms, and without a URDF.

    Raises:
        DataError: The folder's files cannot be read.
        RobotError: The URDF has no such flange or joints.
    """
    if folder is None or not (folder / FILES[CALIBRATION]).is_file():
        return None
    saved = read_result(folder, CALIBRATION)[1]
    if saved.model.robot is None or saved.kind == "motion":
        return None
    names = (saved.model.robot,) if nominal else ("robot_corrected.urdf", saved.model.robot)
    file = next((folder / name for name in names if (folder / name).is_file()), None)
    return None if file is None else saved.model.arm(read_text(file, ROBOT_BYTES), file)


def run_in(folder: Path | None) -> dict[str, Any]:
    """The run of calibration.json in a folder, also that of a diagnosis beside it."""
    if folder is None or not (folder / FILES[CALIBRATION]).is_file():
        return {}
    return {"run": read_result(folder, CALIBRATION)[0].get("run")}


def numbers_of(contents: Mapping[str, Any]) -> dict[str, Any]:
    """The entry of each parameter in a calibration or a diagnosis, of effects as `EFFECT.WHERE.PARAMETER`."""
    of_effects = {
        f"{one['effect']}.{one['where']}.{name}": number
        for one in contents["effects"]
        for name, number in one["parameters"].items()
    }
    return {**contents.get("parameters", {}), **of_effects}
