"""The page of a diagnosis: one file that needs nothing else."""

from robolaser.diagnosis.result import Diagnosis
from robolaser.model.noise.sources import error_sources
from robolaser.report.calibration.error_analysis import enough_rows
from robolaser.report.diagnosis import rows
from robolaser.report.diagnosis.advice import to_do
from robolaser.report.diagnosis.charts import FIRST, THEN
from robolaser.report.digits import millimetre_interval, millimetres
from robolaser.report.page import drawn, render
from robolaser.report.setting import noise_lines, setting

VERDICTS = {
    "no_gap": "no gap",
    "explained": "explained",
    "unexplained": "unexplained",
}
FEW = 8
"""Rows of a table of details from which it is folded away."""


def page(diagnosis: Diagnosis, *, command: str = "") -> str:
    """The page as HTML.

    Args:
        diagnosis: The result.
        command: What to type to repeat it.
    """
    lead, _, sense = diagnosis.sentence.partition(". ")
    joints, poses = rows.pose_table(diagnosis)
    sources = error_sources(enough_rows(diagnosis.model), diagnosis.x)
    sizes = {name: source.value for name, source in diagnosis.noise.items()}
    return render(
        "diagnosis.html",
        diagnosis=diagnosis,
        dataset=diagnosis.dataset,
        verdict=VERDICTS[diagnosis.verdict],
        setting=setting(diagnosis.dataset),
        lead=f"{lead.rstrip('.')}.",
        sense=sense,
        gap=gap_lines(diagnosis),
        classes=rows.class_rows(diagnosis),
        effects=rows.effect_rows(diagnosis),
        alternatives=rows.alternative_rows(diagnosis),
        sites=rows.site_rows(diagnosis),
        validation=list(rows.validation_rows(diagnosis)),
        limits=list(rows.limit_rows(diagnosis)),
        untestable=rows.untestable_rows(diagnosis),
        joints=joints,
        next_poses=poses,
        gross=list(rows.gross_rows(diagnosis)),
        noise=[(*line, diagnosis.noise[line[0]].origin) for line in noise_lines(sizes, sources)],
        to_do=to_do(diagnosis),
        first=drawn([make(diagnosis) for make in FIRST]),
        charts=drawn([make(diagnosis) for make in THEN]),
        few=FEW,
        command=command,
    )


def gap_lines(diagnosis: Diagnosis) -> list[tuple[str, str, str]]:
    """The gap step by step: what, how much, and how to read it."""
    gap = diagnosis.gap
    low, high = gap.after_ci95_m
    lines = [
        ("nominal model", millimetres(gap.nominal_m), "before anything was fitted"),
        ("calibrated", millimetres(gap.calibrated_m), "ordinary parameters fitted, no effect in the model"),
        ("with the effects", millimetres(gap.after_m), f"95 %: {millimetre_interval(low, high)}"),
        ("noise alone", millimetres(gap.noise_floor_m), "what a perfect model would leave"),
    ]
    return lines if diagnosis.model.effects else [lines[0], ("calibrated", *lines[2][1:]), lines[3]]
