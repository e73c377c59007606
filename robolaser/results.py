"""What `calibrate`, `diagnose` and `compare` give in Python: results that print, show, tabulate and save themselves."""

import io
import json
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Self, final

import numpy as np
from rich.console import Console

from robolaser.arrays import Array
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_files import comparison_json, runs_csv
from robolaser.benchmark.standings import Standings, standings
from robolaser.bounded_reading import read_json, read_text
from robolaser.calibration.result import FORMAT as CALIBRATION
from robolaser.calibration.result import Calibration, as_json, json_text
from robolaser.data.atomic_write import write_text
from robolaser.data.dataset_file import check_format
from robolaser.data.result_folder import results_in, write_results
from robolaser.diagnosis.corrected_model import corrected, corrected_json
from robolaser.diagnosis.result import Diagnosis
from robolaser.diagnosis.result_json import FORMAT as DIAGNOSIS
from robolaser.diagnosis.result_json import diagnosis_json, diagnosis_text
from robolaser.errors import UsageError, near
from robolaser.export.files import EXPORTED, exported
from robolaser.report import calibration as of_calibration
from robolaser.report import comparison as of_comparison
from robolaser.report import diagnosis as of_diagnosis
from robolaser.report.document import Charts, Document
from robolaser.report.page import charts_in, fragment
from robolaser.report.plots import Plots, plots

if TYPE_CHECKING:
    import pandas as pd

PAGE: Final = "report.html"
CALIBRATION_FILES: Final = ("calibration.json", PAGE, *EXPORTED)
DIAGNOSIS_FILES: Final = ("diagnosis.json", *CALIBRATION_FILES)
FINDING: Final = [
    "effect", "where", "probability", "parameters", "gap_mm_before", "gap_mm_after", "gap_mm_without",
    "indistinguishable_from",
]  # fmt: skip
Files = Mapping[str, str | None]


class Record(dict[str, Any]):
    """A dictionary whose entries are attributes, too."""

    def __init__(self, contents: Mapping[str, Any]) -> None:
        super().__init__({key: _recorded(value) for key, value in contents.items()})

    def __getattr__(self, name: str) -> Any:
        if name not in self:
            raise AttributeError(f"No '{name}'.{near(name, self)}")
        return self[name]

    def __dir__(self) -> list[str]:
        """Methods and entries, for completion at a prompt."""
        return [*super().__dir__(), *filter(str.isidentifier, self)]


class Result(ABC):
    """A result."""

    @abstractmethod
    def to_dict(self) -> dict[str, Any]:
        """What its JSON file holds."""

    @abstractmethod
    def to_frame(self) -> "pd.DataFrame":
        """A row for each parameter of a calibration, effect of a diagnosis, or run of a comparison."""

    @abstractmethod
    def files(self, *, command: str = "") -> Files:
        """The files of the result by name; None for one that this result does not have.

        Args:
            command: What to type to repeat it.
        """

    @abstractmethod
    def _document(self, *, brief: bool) -> Document | None:
        """The report; None for a result that was read back."""

    @abstractmethod
    def __str__(self) -> str:
        """The summary that the command prints."""

    def save(self, folder: str | Path) -> None:
        """Write the files that the command of this name writes.

        Raises:
            OutputError: The folder cannot be written to, or holds a file of such a name that is no earlier result.
        """
        files, path = self.files(), Path(folder)
        command = {CALIBRATION: "calibrate", DIAGNOSIS: "diagnose"}.get(self.to_dict()["format"], "compare")
        with results_in(path, command=command, files=list(files), force=True):
            write_results(path, files)

    def report(self, path: str | Path) -> None:
        """Write the report, one HTML page.

        Raises:
            OutputError: The file cannot be written.
        """
        page = self.files().get(PAGE)
        write_text(Path(path), page or f"<!doctype html><meta charset=utf-8>{self._repr_html_()}")

    def plot(self, title: str = "") -> Plots:
        """The charts of the report.

        Args:
            title: Only those with a word of the title that begins with this; all of them by default.

        Raises:
            UsageError: There is none of that title.
        """
        document = self._document(brief=False)
        if document is None:
            known = charts_in(self.files().get(PAGE) or "")
        else:
            known = [chart for block in document.blocks if isinstance(block, Charts) for chart in block.charts]
        shown = [chart for chart in known if re.search(rf"\b{re.escape(title)}", chart.title, re.IGNORECASE)]
        if not shown:
            raise UsageError(f"No chart '{title}'.{near(title, [chart.title for chart in known])}")
        return plots(shown)

    def __repr__(self) -> str:
        """The summary, too: what a person sees who names a result at a prompt."""
        return str(self).rstrip("\n")

    def _repr_html_(self) -> str:
        document = self._document(brief=True)
        return f"<pre>{escape(str(self))}</pre>" if document is None else fragment(document)


class FittedResult(Result, Record):
    """A result that reads like its JSON file, by key or by attribute."""

    def __init__(self, contents: Mapping[str, Any], folder: Path | None = None) -> None:
        super().__init__(contents)
        self._folder = folder

    def value(self, name: str) -> float:
        """The estimated value of a parameter, or of an effect's: `laser_roll.laser.angle`.

        Raises:
            UsageError: There is no parameter of that name.
        """
        numbers = numbers_of(self)
        if name not in numbers:
            raise UsageError(f"No parameter '{name}'.{near(name, numbers)}")
        return float(numbers[name]["value"])

    def to_dict(self) -> dict[str, Any]:
        """What its JSON file holds."""
        plain: dict[str, Any] = json.loads(json.dumps(self))
        return plain

    def _saved(self, names: Sequence[str]) -> Files:
        """The files of a result that was read back."""
        folder = self._folder or Path()
        return {name: read_text(folder / name) for name in names if (folder / name).is_file()}


@final
class CalibrationResult(FittedResult):
    """A calibration: the entries of calibration.json, as a dictionary and as attributes.

    Attributes:
        calibration: With model and residuals, whose attributes are this result's, too; None if it was read back.

    Examples:
        >>> found = robolaser.calibrate(dataset)
        >>> found.value("f")
        0.008
        >>> found.parameters["f"].unit
        'm'
        >>> found.to_frame().loc["b", "unit"]
        'm'
    """

    def __init__(
        self, contents: Mapping[str, Any], made: Calibration | None = None, folder: Path | None = None
    ) -> None:
        super().__init__(contents, folder)
        self.calibration = made

    @classmethod
    def of(cls, made: Calibration) -> Self:
        """A calibration that was just made."""
        return cls(as_json(made), made)

    def __getattr__(self, name: str) -> Any:
        made = self.__dict__.get("calibration")
        return getattr(made, name) if made is not None and name not in self else super().__getattr__(name)

    @property
    def x(self) -> Array:
        """The values of all parameters, those of effects last, (d,)."""
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
        if self.calibration is None:
            return self._saved(CALIBRATION_FILES)
        page = of_calibration.page(self.calibration, command=command)
        return {**exported(self.calibration), PAGE: page, "calibration.json": json_text(self.calibration)}

    def _document(self, *, brief: bool) -> Document | None:
        return None if self.calibration is None else of_calibration.document(self.calibration, brief=brief)

    def __str__(self) -> str:
        """The summary that the command prints."""
        if self.calibration is None:
            return f"{self.dataset}: rms {1e3 * self.rms_m:.3g} mm on fitted poses\n{self.to_frame().to_string()}\n"
        return _printed(lambda out: of_calibration.print_summary(self.calibration, console=out))


@final
class DiagnosisResult(FittedResult):
    """A diagnosis: the entries of diagnosis.json, as a dictionary and as attributes.

    Attributes:
        diagnosis: With all that a report shows; None if it was read back.

    Examples:
        >>> why = robolaser.diagnose(dataset, effects=[], seed=1)
        >>> why.verdict, why["effects"]
        ('no_gap', [])
    """

    def __init__(
        self, contents: Mapping[str, Any], made: Diagnosis | None = None, seed: int = 0, folder: Path | None = None
    ) -> None:
        super().__init__(contents, folder)
        self.diagnosis, self._seed = made, seed

    @classmethod
    def of(cls, made: Diagnosis, seed: int) -> Self:
        """A diagnosis that was just made with this seed."""
        return cls(diagnosis_json(made), made, seed)

    @cached_property
    def model(self) -> Calibration | None:
        """The corrected model, as a calibration; None if the result was read back."""
        return None if self.diagnosis is None else corrected(self.diagnosis, self._seed)

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
            "calibration.json": corrected_json(self.model),
            PAGE: of_diagnosis.page(self.diagnosis, command=command),
            "diagnosis.json": diagnosis_text(self.diagnosis),
        }

    def _document(self, *, brief: bool) -> Document | None:
        return None if self.diagnosis is None else of_diagnosis.document(self.diagnosis, brief=brief)

    def __str__(self) -> str:
        """The summary that the command prints."""
        if self.diagnosis is None:
            return f"{self.dataset}: {self.sentence}\n{self.to_frame().to_string()}\n"
        return _printed(lambda out: of_diagnosis.print_diagnosis(self.diagnosis, console=out))


@final
class ComparisonResult(Result):
    """A comparison of algorithms, whose attributes are those of its `BenchmarkResult`.

    Attributes:
        benchmark: All runs.

    Examples:
        >>> plan = robolaser.RunPlan.of(["pymoo:sphere-2"], ["de"], seeds=1, budget=100)
        >>> robolaser.compare(plan).to_frame()["state"].tolist()
        ['done']
    """

    def __init__(self, benchmark: BenchmarkResult) -> None:
        self.benchmark = benchmark

    def __getattr__(self, name: str) -> Any:
        if name == "benchmark":  # of an object that is being unpickled
            raise AttributeError(name)
        return getattr(self.benchmark, name)

    def to_dict(self) -> dict[str, Any]:
        """What comparison.json holds."""
        read: dict[str, Any] = json.loads(comparison_json(self.benchmark, self._ranked))
        return read

    def to_frame(self, of: Any = "runs") -> "pd.DataFrame":
        """The runs, or their "trajectory" or "targets", as `BenchmarkResult.to_frame` has them."""
        return self.benchmark.to_frame(of)

    def files(self, *, command: str = "") -> Files:
        """runs.csv, comparison.json and the report."""
        page = of_comparison.page(self.benchmark, self._ranked, command=command)
        text = comparison_json(self.benchmark, self._ranked)
        return {"runs.csv": runs_csv(self.benchmark), PAGE: page, "comparison.json": text}

    def _document(self, *, brief: bool) -> Document:
        return of_comparison.document(self.benchmark, self._ranked, brief=brief)

    def __str__(self) -> str:
        """The summary that the command prints."""
        return _printed(lambda out: of_comparison.print_comparison(self.benchmark, self._ranked, console=out))

    @property
    def _ranked(self) -> tuple[Standings, ...]:
        return tuple(standings(self.benchmark, family) for family in self.benchmark.families)


def load_calibration(path: str | Path) -> CalibrationResult:
    """A calibration read back from calibration.json or its folder.

    Raises:
        DataError: It cannot be read, or is of another format.

    Examples:
        >>> robolaser.calibrate(dataset).save("result")
        >>> robolaser.load_calibration("result").value("f")
        0.008
    """
    contents, folder = _read(Path(path), "calibration.json", CALIBRATION)
    return CalibrationResult(contents, folder=folder)


def load_diagnosis(path: str | Path) -> DiagnosisResult:
    """A diagnosis read back from diagnosis.json or its folder.

    Raises:
        DataError: It cannot be read, or is of another format.

    Examples:
        >>> robolaser.diagnose(dataset, effects=[]).save("why")
        >>> robolaser.load_diagnosis("why").effects
        []
    """
    contents, folder = _read(Path(path), "diagnosis.json", DIAGNOSIS)
    return DiagnosisResult(contents, folder=folder)


def _read(path: Path, name: str, expected: str) -> tuple[dict[str, Any], Path]:
    file = path / name if path.is_dir() else path
    contents = read_json(file)
    contents = contents if isinstance(contents, dict) else {}
    check_format(contents, expected, file.name)
    return contents, file.parent


def numbers_of(contents: Mapping[str, Any]) -> dict[str, Any]:
    """What a calibration or a diagnosis holds of each parameter, those of effects as `EFFECT.WHERE.PARAMETER`."""
    of_effects = {
        f"{one['effect']}.{one['where']}.{name}": number
        for one in contents["effects"]
        for name, number in one["parameters"].items()
    }
    return {**contents.get("parameters", {}), **of_effects}


def _recorded(value: Any) -> Any:
    if isinstance(value, Mapping):
        return Record(value)
    is_list = isinstance(value, Sequence) and not isinstance(value, str)
    return [_recorded(one) for one in value] if is_list else value


def _printed(show: Any) -> str:
    text = io.StringIO()
    show(Console(file=text, force_terminal=False, force_jupyter=False))
    return text.getvalue()
