"""The page of a calibration: one file that needs nothing else."""

from dataclasses import dataclass
from pathlib import Path
from typing import final

from robolaser.calibration.result import Calibration
from robolaser.data.atomic_write import write_text
from robolaser.report.calibration import words
from robolaser.report.calibration.charts import CHARTS
from robolaser.report.calibration.error_analysis import ErrorAnalysis
from robolaser.report.calibration.rows import effect_rows, parameter_rows
from robolaser.report.digits import SIGNIFICANT, millimetres, plain
from robolaser.report.page import drawn, render
from robolaser.report.setting import setting

MANY = 24
"""Rows of closed-form parameters from which they are folded away."""


@final
@dataclass(frozen=True)
class Figure:
    """One of the figures at the head of the page.

    Attributes:
        kind: For the style sheet.
        label: What it is.
        value: With its unit.
        share: Of the largest one, in per cent; None where unknown.
        remark: How to read it.
    """

    kind: str
    label: str
    value: str
    share: float | None
    remark: str


def figures(analysis: ErrorAnalysis) -> list[Figure]:
    """Error on new poses, what noise implies, and the error on the poses that were fitted; then those of rotations."""
    calibration = analysis.calibration
    sources = ", ".join(analysis.known_noise)
    rows = calibration.row_errors[0]
    shown = (
        ("held-out", "on new poses", calibration.held_out_rms_m,
         f"predicted with each pose left out of the fit{_in_unit(rows.held_out_rms, rows.unit)}"),
        ("noise", "noise alone", analysis.noise_m, f"known noise: {sources}" if sources else "no noise is known"),
        ("fitted", "on fitted poses", calibration.rms_m, f"training error, optimistic{_in_unit(rows.rms, rows.unit)}"),
    )  # fmt: skip
    angles = [each for each in calibration.row_errors if each.unit == "rad"]
    turn = "turn of bodies about three axes together"
    turns = [
        Figure(kind, label, plain(error, "rad", SIGNIFICANT), None, f"{each.sensor}: {turn}" if angles[1:] else turn)
        for each in angles
        for kind, label, error in (
            ("held-out", "new poses, turn", each.held_out_rms),
            ("fitted", "fitted, turn", each.rms),
        )
        if error is not None
    ]
    largest = max(error for _, _, error, _ in shown if error is not None) or 1.0
    lengths = [
        Figure(kind, label, millimetres(error), None if error is None else 100 * error / largest, remark)
        for kind, label, error, remark in shown
    ]
    return lengths + turns


def _in_unit(rms: float | None, unit: str) -> str:
    """The error in the rows' own unit, where that is no metre; a row's two pixels are one length."""
    return "" if rms is None or unit == "m" else f"; {rms:.3g} {unit}"


def page(calibration: Calibration, *, command: str = "") -> str:
    """The page as HTML.

    Args:
        calibration: The result.
        command: What to type to repeat it.
    """
    analysis = ErrorAnalysis(calibration)
    given, placed = parameter_rows(calibration)
    return render(
        "calibration.html",
        dataset=calibration.model.dataset,
        setting=setting(calibration.model.dataset),
        calibration=calibration,
        words=words,
        analysis=analysis,
        figures=figures(analysis),
        given=given,
        placed=placed,
        folded=len(placed) > MANY,
        effects=effect_rows(calibration),
        charts=drawn([make(analysis) for make in CHARTS]),
        command=command,
    )


def write_report(calibration: Calibration, path: Path, *, command: str = "") -> None:
    """Write the page of a calibration, one self-contained HTML file.

    Raises:
        OutputError: The disk or the permissions do not allow it.
    """
    write_text(path, page(calibration, command=command))
