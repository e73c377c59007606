"""Diagnoses that were just made or read back."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self, final

from robolaser.calibration.result import Calibration
from robolaser.diagnosis.corrected_model import corrected, corrected_json
from robolaser.diagnosis.result import Diagnosis
from robolaser.diagnosis.result_json import FORMAT, diagnosis_json
from robolaser.export.files import exported
from robolaser.report import diagnosis as of_diagnosis
from robolaser.report.document import Document
from robolaser.results import PAGE, Files, FittedResult, json_text, printed, read_back, robot_in
from robolaser.results.calibration import CALIBRATION_FILES
from robolaser.results.delivered import Delivered, delivered
from robolaser.robot.kinematics import Robot

if TYPE_CHECKING:
    import pandas as pd

DIAGNOSIS_FILES: Final = ("diagnosis.json", *CALIBRATION_FILES)
FINDING: Final = [
    "effect", "where", "probability", "parameters", "gap_mm_before", "gap_mm_after", "gap_mm_without",
    "indistinguishable_from",
]  # fmt: skip


@final
class DiagnosisResult(FittedResult):
    """A diagnosis: the entries of diagnosis.json, as a dictionary and as attributes.

    Attributes:
        diagnosis: With all that a report shows; None if it was read back.
        model: The corrected model, as a calibration; None likewise.

    Examples:
        >>> why = robolaser.diagnose(dataset, effects=[], seed=1)
        >>> why.verdict, why["effects"]
        ('no_gap', [])
    """

    command = "diagnose"

    def __init__(
        self,
        contents: Mapping[str, Any],
        made: Diagnosis | None = None,
        model: Calibration | None = None,
        files: Sequence[Delivered] = (),
        folder: Path | None = None,
    ) -> None:
        super().__init__(contents, folder)
        self.diagnosis, self.model, self._delivered = made, model, files

    @classmethod
    def of(cls, made: Diagnosis, seed: int) -> Self:
        """A diagnosis that was just made with this seed."""
        model = corrected(made, seed)
        files = delivered(model)
        return cls(diagnosis_json(made) | {"files": [one.to_dict() for one in files]}, made, model, files)

    @property
    def robot(self) -> Robot | None:
        """The corrected arm: `forward`, `jacobian` and `inverse`, in batches; see `Diagnosis.robot`."""
        return robot_in(self._folder) if self.diagnosis is None else self.diagnosis.robot

    def to_frame(self) -> "pd.DataFrame":
        """A row for each effect."""
        import pandas as pd  # noqa: PLC0415 - half a second that summaries and files do without

        return pd.DataFrame(self.to_dict()["effects"], columns=FINDING)

    def files(self, *, command: str = "") -> Files:
        """diagnosis.json, and the files of the corrected model as a calibration."""
        if self.diagnosis is None:
            return self._saved(DIAGNOSIS_FILES)
        assert self.model is not None
        return {
            **exported(self.model),
            **{one.file: one.text for one in self._delivered},
            "calibration.json": json_text(corrected_json(self.model) | {"files": self.to_dict()["files"]}),
            PAGE: of_diagnosis.page(self.diagnosis, command=command, files=self["files"]),
            "diagnosis.json": json_text(self.to_dict()),
        }

    def _document(self, *, brief: bool) -> Document | None:
        return (
            None if self.diagnosis is None else of_diagnosis.document(self.diagnosis, brief=brief, files=self["files"])
        )

    def __str__(self) -> str:
        """The summary that the command prints."""
        made = self.diagnosis
        if made is None:
            return f"{self.dataset}: {self.sentence}\n{self.to_frame().to_string()}\n"
        return printed(lambda out: of_diagnosis.print_diagnosis(made, console=out, files=self["files"]))


def load_diagnosis(path: str | Path) -> DiagnosisResult:
    """A diagnosis read back from diagnosis.json or its folder.

    Raises:
        DataError: It cannot be read, or is of another format.

    Examples:
        >>> robolaser.diagnose(dataset, effects=[]).save("why")
        >>> robolaser.load_diagnosis("why").effects
        []
    """
    contents, folder = read_back(Path(path), "diagnosis.json", FORMAT)
    return DiagnosisResult(contents, folder=folder)
