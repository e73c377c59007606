"""Calibrations, new or loaded."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration, as_json
from robolaser.calibration.saved import CALIBRATION, numbers_of, read_result, robot_in
from robolaser.data.result_folder import json_text
from robolaser.export.files import EXPORTED, exported
from robolaser.report.calibration import page as of_calibration
from robolaser.report.console import print_document
from robolaser.report.document import Document
from robolaser.report.page import render
from robolaser.results import PAGE, Files, FittedResult, Record
from robolaser.results.delivered import Delivered, arm_in, delivered, nearest_nominal
from robolaser.robot.kinematics import Robot

if TYPE_CHECKING:
    import pandas as pd

    from robolaser.results.motion import MotionCalibrationResult

CALIBRATION_FILES: Final = ("calibration.json", PAGE, *EXPORTED)


@final
class CalibrationResult(FittedResult):
    """A calibration: the entries of calibration.json, as a dictionary and as attributes.

    Attributes:
        calibration: Model and residuals; its attributes are also this result's. None if it was loaded.

    Examples:
        >>> found = robolaser.calibrate(dataset)
        >>> found.value("f")
        0.008
        >>> found.parameters["f"].unit
        'm'
        >>> found.to_frame().loc["b", "unit"]
        'm'
    """

    command = "calibrate"

    def __init__(
        self, contents: Mapping[str, Any], made: Calibration | None = None, folder: Path | None = None
    ) -> None:
        super().__init__(contents, folder)
        self.calibration = made

    @classmethod
    def of(cls, made: Calibration) -> Self:
        """A new calibration."""
        found = cls(as_json(made), made)
        found["files"] = [Record(one.to_dict()) for one in found._delivered]
        return found

    @cached_property
    def _nearest(self) -> Calibration | None:
        return self.calibration and nearest_nominal(self.calibration)

    @cached_property
    def _delivered(self) -> Sequence[Delivered]:
        return () if self._nearest is None else delivered(self._nearest)

    def __getattr__(self, name: str) -> Any:
        made = self.__dict__.get("calibration")
        return getattr(made, name) if made is not None and name not in self else super().__getattr__(name)

    @property
    def robot(self) -> Robot | None:
        """The corrected arm, as its URDF has it: `forward`, `jacobian` and `inverse`, in batches."""
        made = self.calibration
        return robot_in(self._folder) if made is None else arm_in(self._delivered, made.robot)

    @property
    def x(self) -> Array:
        """The values of all parameters, effects last, (d,)."""
        return np.array([number["value"] for number in numbers_of(self).values()])

    @property
    def std(self) -> Array:
        """One standard deviation of each, (d,); NaN where it is fixed or not identifiable."""
        return np.array([number["std"] for number in numbers_of(self).values()], np.float64)

    def to_frame(self) -> "pd.DataFrame":
        """A row for each parameter."""
        import pandas as pd  # noqa: PLC0415 - half a second that summaries and files do without

        return pd.DataFrame.from_dict(numbers_of(self), orient="index").rename_axis("parameter")

    def files(self, *, command: str = "") -> Files:
        """calibration.json, the report, and the files for other programs."""
        if self.calibration is None or self._nearest is None:
            return self._saved(CALIBRATION_FILES)
        return {
            **exported(self._nearest),
            **{one.file: one.text for one in self._delivered},
            PAGE: render(of_calibration.document(self.calibration, files=self["files"]), command),
            "calibration.json": json_text(self.to_dict()),
        }

    def print(self, folder: Path) -> None:
        """Print the summary, with the files for ROS in a folder, and the path of the saved report."""
        if made := self.calibration:
            print_document(of_calibration.document(made, brief=True, files=self["files"], folder=folder), folder)

    def _document(self, *, brief: bool) -> Document | None:
        made = self.calibration
        return None if made is None else of_calibration.document(made, brief=brief, files=self["files"])

    def _read_back(self) -> str:
        errors = (("rms_m", "fitted poses"), ("held_out_rms_m", "poses that were held out"))
        known = [f"rms {1e3 * self[name]:.3g} mm on {what}" for name, what in errors if self[name] is not None]
        return f"{': '.join((self.dataset, *known[:1]))}\n{self.to_frame().to_string()}\n"


def load_calibration(path: str | Path) -> "CalibrationResult | MotionCalibrationResult":
    """Load a calibration from calibration.json or its folder.

    Raises:
        DataError: It cannot be read, or is of another format.

    Examples:
        >>> robolaser.calibrate(dataset).save("result")
        >>> robolaser.load_calibration("result").value("f")
        0.008
    """
    contents, _, folder = read_result(Path(path), CALIBRATION)
    if contents.get("kind") == "motion":
        from robolaser.results.motion import MotionCalibrationResult  # noqa: PLC0415 - measured poses need none of it

        return MotionCalibrationResult(contents, folder=folder)
    return CalibrationResult(contents, folder=folder)
