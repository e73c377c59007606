"""Diagnoses and calibrations of moving arms, new or loaded."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self, final

from robolaser.data.result_folder import json_text
from robolaser.export import servo_table
from robolaser.motion.calibration import MotionFit
from robolaser.motion.diagnosis import MotionDiagnosis
from robolaser.motion.result_json import motion_calibration_json, motion_json
from robolaser.report import motion as of_motion
from robolaser.report.document import Document
from robolaser.report.page import render
from robolaser.results import PAGE, Files, FittedResult

if TYPE_CHECKING:
    import pandas as pd

MOTION_FILES: Final = ("diagnosis.json", servo_table.FILE, PAGE)
MOTION_CALIBRATION_FILES: Final = ("calibration.json", PAGE)


@final
class MotionResult(FittedResult):
    """A diagnosis of a moving arm: the entries of diagnosis.json, as a dictionary and as attributes.

    Attributes:
        diagnosis: All contents of the report; None if it was loaded.
    """

    command = "diagnose"

    def __init__(
        self, contents: Mapping[str, Any], made: MotionDiagnosis | None = None, folder: Path | None = None
    ) -> None:
        super().__init__(contents, folder)
        self.diagnosis = made

    @classmethod
    def of(cls, made: MotionDiagnosis) -> Self:
        """A new diagnosis."""
        contents = motion_json(made)
        return cls(contents | {"files": _delivered(contents)}, made)

    def files(self, *, command: str = "") -> Files:
        """diagnosis.json, the table of the servos' numbers, and the page."""
        if self.diagnosis is None:
            return self._saved(MOTION_FILES)
        found = self.to_dict()
        return {
            "diagnosis.json": json_text(found),
            servo_table.FILE: servo_table.servo_table(found["effects"], found["step_s"]),
            PAGE: render(of_motion.document(self.diagnosis.fit, self.diagnosis), command),
        }

    def _document(self, *, brief: bool) -> Document | None:
        made = self.diagnosis
        return None if made is None else of_motion.document(made.fit, made)


def _delivered(found: dict[str, Any]) -> list[dict[str, Any]]:
    """The table of all the servos' numbers, an entry of `files` that nothing reads back."""
    pairs = dict.fromkeys((one["effect"], one["where"]) for one in found["effects"])
    entry = {"file": servo_table.FILE, "held_out_mm": None, "contains": [*map(list, pairs)], "lacks": []}
    return [entry] if pairs else []


@final
class MotionCalibrationResult(FittedResult):
    """Numbers of effects on a moving arm: the entries of calibration.json, as a dictionary and as attributes.

    Attributes:
        fit: All contents of the report; None if it was loaded.
    """

    command = "calibrate"

    def __init__(self, contents: Mapping[str, Any], made: MotionFit | None = None, folder: Path | None = None) -> None:
        super().__init__(contents, folder)
        self.fit = made

    @classmethod
    def of(cls, made: MotionFit, seed: int) -> Self:
        """A new calibration."""
        return cls(motion_calibration_json(made, seed), made)

    def to_frame(self) -> "pd.DataFrame":
        """A row for each number of each effect."""
        import pandas as pd  # noqa: PLC0415 - half a second that summaries and files do without

        rows = [
            {"effect": one["effect"], "where": one["where"], "parameter": name, **number}
            for one in self.to_dict()["effects"]
            for name, number in one["parameters"].items()
        ]
        return pd.DataFrame(rows, columns=["effect", "where", "parameter", "value", "std", "unit"])

    def files(self, *, command: str = "") -> Files:
        """calibration.json and the page."""
        if self.fit is None:
            return self._saved(MOTION_CALIBRATION_FILES)
        return {"calibration.json": json_text(self.to_dict()), PAGE: render(of_motion.document(self.fit), command)}

    def _document(self, *, brief: bool) -> Document | None:
        return None if self.fit is None else of_motion.document(self.fit)
