"""The report of a diagnosis: a page, and twenty lines on the terminal."""

from collections.abc import Mapping, Sequence
from typing import Any

from robolaser.diagnosis.cause_words import spoken
from robolaser.diagnosis.result import Diagnosis, Gap
from robolaser.report.diagnosis import rows
from robolaser.report.diagnosis.advice import to_do
from robolaser.report.diagnosis.charts import effect_charts, waterfall
from robolaser.report.digits import millimetre_interval, millimetres
from robolaser.report.document import Content, Document, Figure, Figures, Notes, Section, Text, charts
from robolaser.report.error_groups import group_blocks, pose_errors
from robolaser.report.model_scene import cell_scene
from robolaser.report.setting import files_section, limit_table, noise_table, origin, site_lines, untestable

LEAST_SHARE = 0.1  # share of the gap above which a location is marked
MOST_SITES, MOST_ADVICE = 2, 3  # lines of each on the terminal
LIMITS = (
    "Detectable: what would have been found in nine cases out of ten, which causes the error at the tool."
    " Distinguishable: from the most similar effect."
)


def document(diagnosis: Diagnosis, *, brief: bool = False, files: Sequence[Mapping[str, Any]] = ()) -> Document:
    """The report, given `files` of diagnosis.json; in brief without the parts that only a page shows."""
    lead, _, sense = diagnosis.sentence.partition(". ")
    dataset, (used, of) = diagnosis.dataset, diagnosis.poses
    effects, classes = rows.effect_table(diagnosis), rows.class_table(diagnosis)
    found = [classes, effects] if classes.printed else [effects, classes]
    doubts = [rows.alternative_table(diagnosis), rows.gross_table(diagnosis)]
    sites = [(one.site, one.coordinate, one.share) for one in diagnosis.where[:MOST_SITES]]
    if not diagnosis.findings:
        found, doubts = [], [classes, *doubts]
    return Document(
        dataset.name,
        "diagnosed",
        dataset.summary + (f"; effects are sought in {used} of {of} poses" if used < of else ""),
        f"{lead.rstrip('.')}.",
        sense,
        [Figures(figures(diagnosis))],
        [
            Section("What was found", found),
            Section("Where", site_lines(sites, diagnosis.verdict, MOST_SITES) if brief else []),
            Section("What to do", [Notes(to_do(diagnosis), "steps", MOST_ADVICE)]),
            files_section(files),
            Section("What is not certain", doubts),
            *([Section("Noise", [*_remarks(diagnosis), *_untested(diagnosis)])] if brief else _evidence(diagnosis)),
        ],
        verdict=diagnosis.verdict,
        footer=f"The diagnosis took {diagnosis.seconds:.1f} s. {origin(dataset.source, dataset.licence)}",
        prints_lead=True,
    )


def figures(diagnosis: Diagnosis) -> list[Figure]:
    """The gap step by step: name, size and explanation; bars are shares of the error after calibration alone.

    Errors of so few poses that none can be held out are left out: the fit may go through any of their points.
    """
    gap = diagnosis.gap
    fitted = () if gap.is_held_out else (gap.calibrated_m, gap.after_m)
    largest = max(gap.calibrated_m, gap.after_m, gap.noise_floor_m) or 1.0
    has_effects = bool(diagnosis.model.effects)
    is_other = has_effects or gap.after_m != gap.calibrated_m
    other_rows = "without gross errors" if len(diagnosis.outliers) else "with all rows"
    corrected = "data set corrected" if diagnosis.wrong_input else other_rows
    left = "with the effects" if has_effects else corrected if is_other else "calibrated"
    lines = [
        ("", "nominal model", gap.nominal_m, _nominal_remark(gap)),
        ("", "calibrated", gap.calibrated_m, "ordinary parameters fitted, no effect in the model"),
        ("held-out", left, gap.after_m, f"95 %: {millimetre_interval(*gap.after_ci95_m)}"),
        ("noise", "noise alone", gap.noise_floor_m, "the error of a perfect model"),
    ]
    return [
        Figure(kind, label, "none" if size is None else millimetres(size), remark,
               None if size is None or i == 0 else 100 * size / largest)
        for i, (kind, label, size, remark) in enumerate(lines)
        if (is_other or i != 1) and size not in fitted
    ]  # fmt: skip


def _nominal_remark(gap: Gap) -> str:
    """The model of the nominal error; if only placements were fitted, nominal and calibrated are one model."""
    if gap.nominal_m is None:
        return "not all nominal values are given"
    if gap.nominal_m == gap.calibrated_m:
        return "nominal arm; base, tool or sockets fitted"
    return "before anything was fitted"


def suspected(diagnosis: Diagnosis) -> Mapping[str, str]:
    """Locations of the effects found and of the gap, each with its share, if any."""
    shares: dict[str, float] = {}
    for part in diagnosis.where:
        shares[part.site] = shares.get(part.site, 0.0) + part.share
    sites = [finding.candidate_effect.where for finding in diagnosis.findings]
    if diagnosis.verdict == "unexplained" or not sites:
        sites += [site for site, share in shares.items() if share >= LEAST_SHARE]
    return {site: f"{100 * min(1.0, shares[site]):.0f} %" if site in shares else "" for site in dict.fromkeys(sites)}


def _evidence(diagnosis: Diagnosis) -> list[Section]:
    model = diagnosis.model
    both = {"before": diagnosis.before_m, "after": diagnosis.after_m}
    errors = both if model.effects else {"errors on new poses": diagnosis.after_m}
    title = "The cell, and its errors on new poses"
    cell = cell_scene(model, diagnosis.x, errors, title=title, marked=suspected(diagnosis))
    where = "Where the remaining error is" if diagnosis.verdict == "unexplained" else "Where the gap is"
    reading, floor_m = "Each pose is predicted by a fit without it.", diagnosis.gap.noise_floor_m
    each_pose = pose_errors(diagnosis.observed, errors, reading=reading, noise_m=floor_m)
    untested = untestable(diagnosis.not_testable, "What these data cannot test")
    limits = limit_table(sorted(diagnosis.limits, key=lambda one: one.candidate_effect.effect.name), LIMITS)
    noise = noise_table((name, one.value, one.unit, one.origin) for name, one in diagnosis.noise.items())
    of_errors = [
        Section(where, [cell, rows.site_table(diagnosis)]),
        Section("Step by step", charts([waterfall(diagnosis)])),
        Section("What each effect explains", charts(list(effect_charts(diagnosis)))),
        Section("Which errors stand out", group_blocks(diagnosis.observed, errors)),
        Section("Errors", charts([each_pose])),
    ]
    return [
        *(of_errors if diagnosis.gap.is_held_out else []),
        Section("Other data of the same arm", [rows.validation_table(diagnosis)]),
        Section("Poses to measure next", [rows.pose_table(diagnosis)]),
        Section("What was not found", [limits, untested]),
        Section("Noise", [noise, *_remarks(diagnosis)]),
    ]


def _remarks(diagnosis: Diagnosis) -> list[Content]:
    return [Text(remark, "quiet", printed=True) for remark in diagnosis.noise_remarks]


def _untested(diagnosis: Diagnosis) -> list[Content]:
    """Effects that were testable at none of their locations, for the terminal."""
    seen = [limit for limit in diagnosis.limits if limit.size is not None or limit.is_imitated]
    tested = {limit.candidate_effect.effect.name for limit in seen}
    tested |= {found.candidate_effect.effect.name for found in diagnosis.findings}
    names = [spoken(name) for name in diagnosis.not_testable if name not in tested]
    return [Text(f"Not testable or not detectable: {', '.join(names)}", "quiet", printed=True)] if names else []
