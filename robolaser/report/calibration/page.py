"""The page a person looks at after a calibration: one file that needs nothing else."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import jinja2
from markupsafe import Markup

from robolaser.calibration.result import Calibration
from robolaser.data.csv_tables import write_text
from robolaser.report import words
from robolaser.report.digits import millimetres
from robolaser.report.evidence import Evidence
from robolaser.report.rows import effect_rows, parameter_rows

MANY = 24
"""Rows of closed-form parameters from which they are folded away until asked for."""


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


def figures(evidence: Evidence) -> list[Figure]:
    """Error on new poses, what noise implies, and last the error on the poses that were fitted."""
    calibration = evidence.calibration
    sources = ", ".join(evidence.known_noise)
    shown = (
        ("held-out", "on new poses", calibration.held_out_rms_m, "predicted with each pose left out of the fit"),
        ("noise", "noise alone", evidence.noise_m, f"known noise: {sources}" if sources else "no noise is known"),
        ("fitted", "on fitted poses", calibration.rms_m, "in-sample: always the rosier one"),
    )
    largest = max(error for _, _, error, _ in shown if error is not None) or 1.0
    return [
        Figure(kind, label, millimetres(error), None if error is None else 100 * error / largest, remark)
        for kind, label, error, remark in shown
    ]


def page(calibration: Calibration) -> str:
    """The page as HTML."""
    from robolaser.report.pictures import PICTURES  # noqa: PLC0415 - Matplotlib is slow to import

    evidence = Evidence(calibration)
    given, placed = parameter_rows(calibration)
    return render(
        "calibration.html",
        dataset=calibration.model.dataset,
        calibration=calibration,
        words=words,
        evidence=evidence,
        figures=figures(evidence),
        given=given,
        placed=placed,
        folded=len(placed) > MANY,
        effects=effect_rows(calibration),
        pictures=[drawn for draw in PICTURES if (drawn := draw(evidence)) is not None],
    )


def render(template: str, **facts: Any) -> str:
    """Fill a template of this package; whatever comes from data is escaped."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("robolaser", "report/templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"minus": minus, "code": code}
    return environment.get_template(template).render(**facts)


def minus(text: str) -> str:
    """Numbers with a proper minus sign."""
    return text.replace("-", "\u2212")


def code(text: str) -> Markup:
    """Text between backticks as code."""
    parts = text.split("`")
    return Markup("").join(Markup("<code>{}</code>").format(part) if i % 2 else part for i, part in enumerate(parts))


def write_report(calibration: Calibration, path: Path) -> None:
    """Write the page of a calibration, one self-contained HTML file.

    Raises:
        FileUnwritable: The disk or the rights say no.
    """
    write_text(path, page(calibration))
