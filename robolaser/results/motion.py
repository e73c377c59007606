"""Diagnoses of moving arms that were just made."""

import json
from typing import TYPE_CHECKING, Final, final

from robolaser.motion.diagnosis import MotionDiagnosis
from robolaser.motion.result_json import motion_json
from robolaser.report import motion as of_motion
from robolaser.report.document import Document
from robolaser.results import PAGE, Files, FittedResult, printed
from robolaser.results.diagnosis import FINDING

if TYPE_CHECKING:
    import pandas as pd

MOTION_FILES: Final = ("diagnosis.json", PAGE)


@final
class MotionResult(FittedResult):
    """A diagnosis of a moving arm: the entries of diagnosis.json, as a dictionary and as attributes.

    Attributes:
        diagnosis: With all that a report shows.
    """

    command = "diagnose"

    def __init__(self, made: MotionDiagnosis) -> None:
        super().__init__(motion_json(made))
        self.diagnosis = made

    def to_frame(self) -> "pd.DataFrame":
        """A row for each effect."""
        import pandas as pd  # noqa: PLC0415 - half a second that summaries and files do without

        return pd.DataFrame(self.to_dict()["effects"], columns=FINDING)

    def files(self, *, command: str = "") -> Files:
        """diagnosis.json and the page."""
        return {
            "diagnosis.json": json.dumps(self.to_dict(), indent=1) + "\n",
            PAGE: of_motion.page(self.diagnosis, command=command),
        }

    def _document(self, *, brief: bool) -> Document:
        return of_motion.document(self.diagnosis)

    def __str__(self) -> str:
        """The summary that the command prints."""
        return printed(lambda out: of_motion.print_motion(self.diagnosis, console=out))
