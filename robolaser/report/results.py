"""The looks of a result in Python: its summary, table and files."""

import io
import json
from collections.abc import Mapping
from functools import singledispatch
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console

from robolaser.benchmark.export import comparison_json, runs_csv
from robolaser.benchmark.journal import NAME as JOURNAL
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings import Standings, standings
from robolaser.bounded_reading import read_text
from robolaser.calibration.result import FORMAT as CALIBRATION
from robolaser.calibration.result import Calibration, as_json, json_text
from robolaser.data.atomic_write import write_text
from robolaser.data.result_folder import results_in, write_results
from robolaser.data.saved_result import SavedResult, numbers_of
from robolaser.diagnosis.corrected_model import corrected, corrected_json
from robolaser.diagnosis.result_json import FORMAT as DIAGNOSIS
from robolaser.diagnosis.result_json import DiagnosisResult
from robolaser.errors import UsageError, near
from robolaser.export.files import exported
from robolaser.report import calibration as of_calibration
from robolaser.report import comparison as of_comparison
from robolaser.report import diagnosis as of_diagnosis
from robolaser.report.document import Charts, Document
from robolaser.report.notebook_charts import notebook_spec, notebook_svg
from robolaser.report.page import fragment, stills
from robolaser.results import CALIBRATION_FILES, DIAGNOSIS_FILES, Plots, Result

if TYPE_CHECKING:
    import pandas as pd

PAGE: Final = "report.html"
COMMANDS: Final = {CALIBRATION: "calibrate", DIAGNOSIS: "diagnose", "robolaser-comparison/1": "compare"}
FINDING: Final = [
    "effect", "where", "probability", "parameters", "gap_mm_before", "gap_mm_after", "gap_mm_without",
    "indistinguishable_from",
]  # fmt: skip
Files = Mapping[str, str | None]


@singledispatch
def files_of(result: Result, *, command: str = "") -> Files:
    """The files of a result by name; None for one that this result does not have.

    Args:
        result: The result.
        command: What to type to repeat it.
    """
    raise TypeError(f"{type(result).__name__} has no files.")


@files_of.register
def _(result: Calibration, *, command: str = "") -> Files:
    return {
        **exported(result),
        PAGE: of_calibration.page(result, command=command),
        "calibration.json": json_text(result),
    }


@files_of.register
def _(result: DiagnosisResult, *, command: str = "") -> Files:
    model = corrected(result.diagnosis, result.seed)
    return {
        **exported(model),
        "calibration.json": corrected_json(model),
        PAGE: of_diagnosis.page(result.diagnosis, command=command),
        "diagnosis.json": result.text,
    }


@files_of.register
def _(result: BenchmarkResult, *, command: str = "") -> Files:
    ranked = _ranked(result)
    page = of_comparison.page(result, ranked, command=command)
    return {
        JOURNAL: result.journal,
        "runs.csv": runs_csv(result),
        PAGE: page,
        "comparison.json": comparison_json(result, ranked),
    }


@files_of.register
def _(result: SavedResult, *, command: str = "") -> Files:
    names = DIAGNOSIS_FILES if result["format"] == DIAGNOSIS else CALIBRATION_FILES
    return {name: read_text(result.folder / name) for name in names if (result.folder / name).is_file()}


def save(result: Result, folder: Path) -> None:
    """Write the files of a result; only an earlier result of its kind is replaced."""
    files = files_of(result)
    with results_in(folder, command=COMMANDS[result.to_dict()["format"]], files=list(files), force=True):
        write_results(folder, files)


def report(result: Result, path: Path) -> None:
    """Write the report."""
    page = files_of(result).get(PAGE)
    write_text(path, page or f"<!doctype html><meta charset=utf-8>{html_of(result)}")


def dict_of(result: Result) -> dict[str, Any]:
    """What the JSON file of a result holds."""
    if isinstance(result, Calibration):
        return as_json(result)
    if isinstance(result, BenchmarkResult):
        said: dict[str, Any] = json.loads(comparison_json(result, _ranked(result)))
        return said
    return dict(result)  # type: ignore[call-overload,no-any-return]


def frame_of(result: Result) -> "pd.DataFrame":
    """The table of a result."""
    import pandas as pd  # noqa: PLC0415 - half a second that summaries and files do without

    said = result.to_dict()
    if said["format"] == DIAGNOSIS:
        return pd.DataFrame(said["effects"], columns=FINDING)
    return pd.DataFrame.from_dict(numbers_of(said), orient="index").rename_axis("parameter")


def plots_of(result: Result, title: str) -> Plots:
    """The charts of the report whose titles have these words."""
    document = _document(result, brief=False)
    if document is None:
        raise UsageError("A result that was read back has no charts: its report.html shows them.")
    known = [chart for block in document.blocks if isinstance(block, Charts) for chart in block.charts]
    shown = [chart for chart in known if title.lower() in chart.title.lower()]
    if not shown:
        raise UsageError(f"No chart '{title}'.{near(title, [chart.title for chart in known])}")
    return Plots(tuple(chart.title for chart in shown), stills(shown), notebook_spec(shown), notebook_svg(shown))


def summary_of(result: Result) -> str:
    """The summary as plain text."""
    if isinstance(result, SavedResult):
        headline = result.get("sentence") or f"rms {1e3 * result['rms_m']:.3g} mm on fitted poses"
        return f"{result['dataset']}: {headline}\n{frame_of(result).to_string()}\n"
    text = io.StringIO()
    _print(result, Console(file=text, force_terminal=False, force_jupyter=False))
    return text.getvalue()


def html_of(result: Result) -> str:
    """The summary for a notebook."""
    document = _document(result, brief=True)
    return f"<pre>{escape(summary_of(result))}</pre>" if document is None else fragment(document)


def _document(result: Result, *, brief: bool) -> Document | None:
    """The report; None for a result that was read back."""
    if isinstance(result, Calibration):
        return of_calibration.document(result, brief=brief)
    if isinstance(result, DiagnosisResult):
        return of_diagnosis.document(result.diagnosis, brief=brief)
    if isinstance(result, BenchmarkResult):
        return of_comparison.document(result, _ranked(result), brief=brief)
    return None


def _print(result: Result, console: Console) -> None:
    if isinstance(result, Calibration):
        of_calibration.print_summary(result, console=console)
    elif isinstance(result, DiagnosisResult):
        of_diagnosis.print_diagnosis(result.diagnosis, console=console)
    elif isinstance(result, BenchmarkResult):
        of_comparison.print_comparison(result, _ranked(result), console=console)


def _ranked(result: BenchmarkResult) -> tuple[Standings, ...]:
    return tuple(standings(result, family) for family in result.families)
