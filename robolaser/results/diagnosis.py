"""Diagnoses, new or loaded."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self, final

from robolaser.calibration.result import Calibration
from robolaser.calibration.saved import DIAGNOSIS, read_result, robot_in, run_in
from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.data.result_folder import json_text
from robolaser.diagnosis.corrected_model import corrected, corrected_json
from robolaser.diagnosis.growth import with_poses
from robolaser.diagnosis.result import Diagnosis
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.errors import UsageError
from robolaser.export.files import exported
from robolaser.model.effects.run import RunSummary
from robolaser.report.diagnosis import page as of_diagnosis
from robolaser.report.document import Document
from robolaser.report.page import render
from robolaser.results import PAGE, Files, FittedResult, Record
from robolaser.results.calibration import CALIBRATION_FILES
from robolaser.results.delivered import Delivered, arm_in, delivered
from robolaser.robot.kinematics import Robot

if TYPE_CHECKING:
    from robolaser.results.motion import MotionResult

Again = Callable[[Dataset], Diagnosis]
DIAGNOSIS_FILES: Final = ("diagnosis.json", *CALIBRATION_FILES)


@final
class DiagnosisResult(FittedResult):
    """A diagnosis: the entries of diagnosis.json, as a dictionary and as attributes.

    Attributes:
        diagnosis: All contents of the report; None if it was loaded.

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
        *,
        seed: int = 0,
        folder: Path | None = None,
        again: Again | None = None,
    ) -> None:
        super().__init__(contents, folder)
        self.diagnosis, self._seed, self._again = made, seed, again

    @classmethod
    def of(cls, made: Diagnosis, seed: int, again: Again | None = None) -> Self:
        """A new diagnosis.

        Args:
            made: The diagnosis.
            seed: Its seed.
            again: Diagnoses another data set in the same way; without it, the diagnosis cannot grow.
        """
        return cls(diagnosis_json(made), made, seed=seed, again=again)

    def __missing__(self, key: str) -> Any:
        """The files of the corrected arm, written and tested on unseen poses at the first access."""
        if key != "files" or self.diagnosis is None:
            raise KeyError(key)
        self[key] = [Record(one.to_dict()) for one in self._delivered]
        return self[key]

    @cached_property
    def model(self) -> Calibration | None:
        """The corrected model, as a calibration; None if the diagnosis was loaded."""
        return None if self.diagnosis is None else corrected(self.diagnosis, self._seed)

    @cached_property
    def _delivered(self) -> Sequence[Delivered]:
        return () if self.model is None else delivered(self.model)

    def with_poses(self, data: Dataset | str | Path) -> "DiagnosisResult":
        """The diagnosis of more poses; of a few more, in a fraction of the time.

        Probabilities and sizes include the further poses; held-out errors are those of the last full diagnosis. It is
        repeated after 5 % more poses, after a pose that the model does not predict, or if a probability changes by
        0.1.

        Args:
            data: The further poses, or all poses with the old ones first; or their folder.

        Raises:
            DataError: They are of another arm or kind of sensor, or have names of earlier poses.
            UsageError: The diagnosis was loaded.

        Examples:
            >>> why = robolaser.diagnose(dataset, effects=[], seed=1)
            >>> why.with_poses(dataset).verdict
            'no_gap'
        """
        if self.diagnosis is None or self._again is None:
            raise UsageError("A diagnosis that was read back cannot grow: call `robolaser.diagnose` with all poses.")
        dataset = data if isinstance(data, Dataset) else load(data)
        return type(self).of(with_poses(self.diagnosis, dataset, self._again), self._seed, self._again)

    def to_dict(self) -> dict[str, Any]:
        """The contents of diagnosis.json."""
        if self.diagnosis is not None:
            self["files"]  # written at the first access
        return super().to_dict()

    @property
    def robot(self) -> Robot | None:
        """The corrected arm, as its URDF has it: `forward`, `jacobian` and `inverse`, in batches."""
        made = self.diagnosis
        return robot_in(self._folder) if made is None else arm_in(self._delivered, made.robot)

    def _of_data(self) -> dict[str, Any]:
        """The run of calibration.json."""
        if self.diagnosis is not None:
            return {"run": asdict(RunSummary.of(self.diagnosis.dataset))}
        return run_in(self._folder)

    def files(self, *, command: str = "") -> Files:
        """diagnosis.json, and the files of the corrected model as a calibration."""
        if self.diagnosis is None:
            return self._saved(DIAGNOSIS_FILES)
        assert self.model is not None
        return {
            **exported(self.model),
            **{one.file: one.text for one in self._delivered},
            "calibration.json": json_text(corrected_json(self.model) | {"files": self.to_dict()["files"]}),
            PAGE: render(of_diagnosis.document(self.diagnosis, files=self["files"]), command),
            "diagnosis.json": json_text(self.to_dict()),
        }

    def _document(self, *, brief: bool) -> Document | None:
        made = self.diagnosis
        return None if made is None else of_diagnosis.document(made, brief=brief, files=self["files"])


def load_diagnosis(path: str | Path) -> "DiagnosisResult | MotionResult":
    """Load a diagnosis from diagnosis.json or its folder.

    Raises:
        DataError: It cannot be read, or is of another format.

    Examples:
        >>> robolaser.diagnose(dataset, effects=[]).save("why")
        >>> robolaser.load_diagnosis("why").effects
        []
    """
    contents, _, folder = read_result(Path(path), DIAGNOSIS)
    if contents.get("kind") == "motion":
        from robolaser.results.motion import MotionResult  # noqa: PLC0415 - measured poses need none of it

        return MotionResult(contents, folder=folder)
    return DiagnosisResult(contents, folder=folder)
