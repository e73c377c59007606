"""calibration.json, as far as a scan or a picture of the cell needs it."""

from dataclasses import dataclass, field
from typing import Literal, final

from robolaser.data.dataset_file import Pixels
from robolaser.data.toml_schema import NotNegative
from robolaser.geometry.rigid_motion import Quaternion
from robolaser.model.effects.run_summary import RunSummary


@final
@dataclass(frozen=True)
class SavedModel:
    """`model` of a stripe scanner's calibration."""

    sensor: Literal["stripe"]
    stripe_axis: Literal["u", "v"]  # image axis that the stripe runs along
    bracket_quat: Quaternion  # nominal turn of the camera on the flange, (x, y, z, w)
    angles: Literal["xyz", "zyz"]  # order of the hand-eye angles
    image: tuple[Pixels, Pixels]  # width and height [px]
    robot: str | None = None
    flange: str | None = None
    joints: tuple[str, ...] | None = None
    gravity: tuple[float, float, float] | None = None


@final
@dataclass(frozen=True)
class SavedParameter:
    """A number as it was found; of the scanner's, nominal value and bounds, or where it started without these, too."""

    value: float
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
    parameters: dict[str, SavedParameter]


@final
@dataclass(frozen=True)
class SavedCalibration:
    """calibration.json of a stripe scanner, as far as a scan needs it."""

    format: Literal["robolaser-calibration/1"]
    dataset: str
    parameters: dict[str, SavedParameter]
    model: SavedModel
    effects: list[SavedEffect]
    rms_m: NotNegative | None = None
    held_out_rms_m: NotNegative | None = None
    noise: dict[str, NotNegative] = field(default_factory=dict)
    run: RunSummary | None = None


@final
@dataclass(frozen=True)
class SavedImages:
    """`model` of any calibration."""

    image: tuple[Pixels, Pixels] | None = None  # width and height [px]


@final
@dataclass(frozen=True)
class SavedCell:
    """calibration.json of any sensor, as far as a picture of it needs it."""

    effects: list[SavedEffect]
    model: SavedImages
    parameters: dict[str, SavedParameter] = field(default_factory=dict)
    run: RunSummary | None = None
