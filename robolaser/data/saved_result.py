"""Results of commands, read back from their folders."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, final

from robolaser.bounded_reading import read_json
from robolaser.data.dataset_file import check_format
from robolaser.errors import UsageError, near
from robolaser.results import Result


@final
class SavedResult(Result, dict[str, Any]):
    """A result read back: it reads like its dictionary, and its files are those of its folder.

    Attributes:
        folder: Where it was saved.
    """

    def __init__(self, contents: Mapping[str, Any], folder: Path) -> None:
        super().__init__(contents)
        self.folder = folder

    def value(self, name: str) -> float:
        """The estimated value of a parameter, or of an effect's: `laser_roll.laser.angle`.

        Raises:
            UsageError: There is no parameter of that name.
        """
        numbers = numbers_of(self)
        if name not in numbers:
            raise UsageError(f"No parameter '{name}'.{near(name, numbers)}")
        return float(numbers[name]["value"])


def numbers_of(contents: Mapping[str, Any]) -> dict[str, Any]:
    """What a calibration or a diagnosis holds of each parameter, those of effects as `EFFECT.WHERE.PARAMETER`."""
    of_effects = {
        f"{one['effect']}.{one['where']}.{name}": number
        for one in contents["effects"]
        for name, number in one["parameters"].items()
    }
    return {**contents.get("parameters", {}), **of_effects}


def load_calibration(path: str | Path) -> SavedResult:
    """A calibration read back from calibration.json or its folder.

    Raises:
        DataError: It cannot be read, or is of another format.

    Examples:
        >>> robolaser.calibrate(dataset).save("result")
        >>> robolaser.load_calibration("result").value("f")
        0.008
    """
    return _load(Path(path), "calibration.json", "robolaser-calibration/1")


def load_diagnosis(path: str | Path) -> SavedResult:
    """A diagnosis read back from diagnosis.json or its folder.

    Raises:
        DataError: It cannot be read, or is of another format.

    Examples:
        >>> robolaser.diagnose(dataset, effects=[]).save("why")
        >>> robolaser.load_diagnosis("why")["effects"]
        []
    """
    return _load(Path(path), "diagnosis.json", "robolaser-diagnosis/1")


def _load(path: Path, name: str, expected: str) -> SavedResult:
    file = path / name if path.is_dir() else path
    contents = read_json(file)
    check_format(contents if isinstance(contents, dict) else {}, expected, file.name)
    return SavedResult(contents, file.parent)
