"""What `calibrate`, `diagnose` and `compare` give in Python: results that print, show, tabulate and save themselves."""

from html import escape
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    import pandas as pd

EXPORTED: Final = (
    "robot.urdf", "robot_corrected.urdf", "camera.yaml", "static_transform.sh", "easy_handeye2.calib",
    "robot_corrected.xml", "robot_corrected.sdf", "corrected.py",
)  # fmt: skip
"""What a calibration leaves for other programs."""


class Result:
    """A result; how it looks is known to `robolaser.report.results`, which is loaded when it is asked for."""

    def to_dict(self) -> dict[str, Any]:
        """What its JSON file holds."""
        said: dict[str, Any] = _shown().dict_of(self)
        return said

    def to_frame(self) -> "pd.DataFrame":
        """A row for each parameter of a calibration, effect of a diagnosis, or run of a comparison."""
        frame: pd.DataFrame = _shown().frame_of(self)
        return frame

    def save(self, folder: str | Path) -> None:
        """Write the files that the command of this name writes.

        Raises:
            OutputError: The folder cannot be written to, or holds a file of such a name that is no earlier result.
        """
        _shown().save(self, Path(folder))

    def report(self, path: str | Path) -> None:
        """Write the report, one HTML page.

        Raises:
            OutputError: The file cannot be written.
        """
        _shown().report(self, Path(path))

    def __str__(self) -> str:
        """The summary that the command prints."""
        text: str = _shown().summary_of(self)
        return text

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"


def _shown() -> Any:
    return import_module("robolaser.report.results")
