"""Reports on a moving arm: a diagnosis, a calibration, and the detection limits of planned motions."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robolaser.diagnosis.cause_words import sentence_case, spoken
from robolaser.motion.calibration import MotionFit
from robolaser.motion.diagnosis import MotionDiagnosis
from robolaser.motion.effect import TIMING, At
from robolaser.motion.gap import FEWEST_RUNS, KindGap, root_mean_squares_of_runs
from robolaser.motion.log import MotionLog
from robolaser.motion.plan import MotionLimit, MotionPlan
from robolaser.motion.result_json import kinds_json, next_motions, sentence
from robolaser.motion.selection import SelectedEffect
from robolaser.report.chart import FITTED, HELD_OUT, Chart, chart, colours, hover, layer, line, quantity, records
from robolaser.report.digits import SIGNIFICANT, measured, millimetre_interval, millimetres, percent, plain, with_unit
from robolaser.report.document import Column, Document, Figure, Figures, Notes, Section, Table, TableCell, Text, charts
from robolaser.report.setting import origin, site_lines, untestable

SHOWN_ROWS = 400  # of a run, in a chart
MOST_PLACES = 5  # that the terminal shows
NOT_APART = "these motions do not distinguish it from "
WHAT = {
    "tracking": "readings against commands",
    "torque": "torques against inverse dynamics",
    "load": "one encoder against the other",
}
TURN = 180.0 / np.pi
UNITS = {"rad": ("°", TURN), "rad/Nm": ("°/Nm", TURN), "rad/s": ("°/s", TURN), "s": ("ms", 1e3)}
"""Unit that people read of a moving arm, and its factor, by SI unit; other units are shown as they are."""


def document(fit: MotionFit, found: MotionDiagnosis | None = None) -> Document:
    """The report on a fit of effects that a user chose, or that a diagnosis found."""
    log, count = fit.log, len(fit.findings)
    sense = "" if count else "Name some with --with, or let `robolaser diagnose` find them."
    lead = f"{count or 'No'} {'effects were' if count > 1 else 'effect was'} fitted."
    sites = [(one.site, one.coordinate, one.share) for one in (found.places if found else ())]
    if found is not None:
        lead, _, sense = sentence(found).partition(". ")
    return Document(
        log.name,
        "diagnosed" if found else "calibrated",
        headline(log),
        f"{lead.rstrip('.')}.",
        sense,
        [Figures(_figures(fit))],
        [
            Section("What was found", [*([_kinds(found)] if found else []), _effects(fit, sure=bool(found))]),
            Section("What to do", [Notes(_steps(found) if found else [], "steps", 3)]),
            Section("Where", site_lines(sites, found.verdict, 1) if found else []),
            Section("Errors of each joint", [_joints(gap, log.joints) for gap in fit.gaps]),
            Section("Errors along time", charts([_along_time(fit)])),
            Section("What was not tested", [untestable(found.not_testable)] if found else []),
            Section("Remarks", [Text(remark, "quiet", printed=True) for remark in (found.remarks if found else ())]),
        ],
        verdict=found.verdict if found else "",
        footer=f"The {'diagnosis' if found else 'calibration'} took {fit.seconds:.1f} s. "
        + origin(log.source, log.licence),
        prints_lead=True,
    )


def headline(log: MotionLog) -> str:
    """The recorded data and their arm."""
    return (
        f"moving arm, robot {log.robot.name}, {len(log)} rows of {len(log.joints)} joints in {len(log.series)} series"
    )


def _figures(fit: MotionFit) -> list[Figure]:
    rows = []
    for gap in fit.gaps:
        largest = max(map(gap.whole, ("calibrated", "after", "noise_floor"))) or 1.0
        for kind, label, name in (("", "before", "calibrated"), ("held-out", "with the effects", "after"),
                                  ("noise", "noise alone", "noise_floor")):  # fmt: skip
            value = gap.whole(name)
            rows.append(
                Figure(kind, label, plain(value, gap.unit, SIGNIFICANT), WHAT[gap.kind], 100.0 * value / largest)
            )
    at_flange = fit.gap_mm
    if at_flange["after"] is not None:
        low, high = at_flange["after_ci95"]
        interval = millimetre_interval(low / 1e3, high / 1e3)
        text = f"{millimetres(at_flange['calibrated'] / 1e3)} before; 95 %: {interval}"
        rows.append(Figure("held-out", "at the flange", millimetres(at_flange["after"] / 1e3), text))
    return rows


def _kinds(found: MotionDiagnosis) -> Table:
    clauses = {one.at.effect.name: one.at.effect.clause for one in found.fit.findings}
    rows = [
        (
            TableCell(spoken(kind["effect"]), below=[clauses[kind["effect"]]]),
            ", ".join(kind["where"]),
            TableCell(percent(kind["probability"]), order=kind["probability"]),
        )
        for kind in kinds_json(found.fit)
    ]
    columns = [Column("Effect", "name", 40, "effect"), Column("At", brief="at"), Column("How sure", brief="how sure")]
    return Table(columns, rows, title="Kinds of effects", printed=8)


def _effects(fit: MotionFit, *, sure: bool) -> Table:
    rows: list[tuple[TableCell | str, ...]] = [
        (
            TableCell(_at(one.at), below=[NOT_APART + " or ".join(map(_at, one.rivals))] if one.rivals else []),
            _numbers(one),
            *([TableCell(percent(one.probability), order=one.probability)] if sure else []),
        )
        for one in fit.findings
    ]
    columns = [Column("Effect", "name", 40, "effect"), Column("How large", brief="how large"),
               Column("How sure", brief="how sure")]  # fmt: skip
    return Table(columns if sure else columns[:2], rows, title="At each location", printed=MOST_PLACES if sure else 20)


def _at(at: At) -> str:
    name = spoken(at.effect.name)
    clock = f"{name} of the {SHOWN_BY[at.effect.rows]}"
    return f"{name} at {at.where}" if at.effect.site == "joint" else clock if at.effect.site == TIMING else name


def _numbers(one: SelectedEffect) -> str:
    """At most three numbers with their errors."""
    shown = [
        f"{name.replace('_', ' ')} {_with_error(value, deviation, unit)}"
        for name, (value, deviation, unit) in one.numbers.items()
        if np.isfinite(value)
    ]
    return "; ".join(shown[:3]) + (f" and {len(shown) - 3} more" if len(shown) > 3 else "")


def _with_error(value: float, deviation: float, unit: str) -> str:
    shown, factor = UNITS.get(unit, (unit, 1.0))
    is_known = np.isfinite(deviation) and 0.0 < deviation <= 10.0 * abs(value)
    if not is_known:
        return with_unit(f"{factor * value:.3g}", shown)
    return measured(factor * value, factor * deviation, shown)


def _steps(found: MotionDiagnosis) -> list[str]:
    """Remedies, each once, then motions to record."""
    known = {one.at.effect.name: one.at for one in found.fit.findings}
    effects: dict[str, list[str]] = {}
    for one in kinds_json(found.fit):
        at = known[one["effect"]]
        effects.setdefault(at.effect.remedy, []).append(_at(replace(at, where=", ".join(one["where"]))))
    remedies = [f"{sentence_case('; '.join(names))}: {remedy}" for remedy, names in effects.items()]
    return [*remedies, *next_motions(found)]


def _joints(gap: KindGap, joints: tuple[str, ...]) -> Table:
    columns = [Column("Joint", "name"), *(Column(title, "number") for title in ("Nominal", "Before", "After", "Noise"))]
    errors = zip(gap.nominal, gap.calibrated, gap.after, gap.noise_floor, strict=True)
    rows: list[tuple[TableCell | str, ...]] = [
        (joint, *(TableCell(plain(value, gap.unit, SIGNIFICANT), order=value) for value in of_joint))
        for joint, of_joint in zip(joints, errors, strict=True)
        if np.isfinite(of_joint[1])
    ]
    note = "RMS. Nominal: nothing fitted; before: constant offsets fitted; after: effects fitted, on held-out motions."
    return Table(columns, rows, title=WHAT[gap.kind].capitalize(), note=note)


def _along_time(fit: MotionFit) -> Chart | None:
    """Tracking errors of the joint with the largest gap in its worst run, before and after."""
    part, log = next((part for part in fit.parts if part.gap.kind == "tracking"), None), fit.log
    if part is None:
        return None
    joint = int(np.nanargmax(part.gap.calibrated))
    error = part.before[:, joint]
    rows = log.rows_of_runs[int(np.nanargmax(root_mean_squares_of_runs(error, log.run)))]
    kept = slice(rows.start, rows.stop, max(1, (rows.stop - rows.start) // SHOWN_ROWS))
    time, n = log.time_s[kept], len(log.time_s[kept])
    data = records(
        time=np.tile(time, 2),
        error=TURN * np.concatenate([error[kept], part.after[kept, joint]]),
        series=["before"] * n + ["after, unseen"] * n,
    )
    name, held = log.series[log.run[rows.start]], "which was" if len(log.series) >= FEWEST_RUNS else "each part of it"
    return chart(
        f"Errors of {log.joints[joint]}",
        f"Reading minus command (before) and minus the model's response to it (after), in the series '{name}', {held}"
        " held out of the fit.",
        f"Errors of {log.joints[joint]} along time, before and after.",
        [layer(line(), data, x=quantity("time", "time [s]"), y=quantity("error", "error [°]"),
               color=colours({"before": HELD_OUT, "after, unseen": FITTED}),
               tooltip=hover("series", time="time [s]", error="error [°]"))],
    )  # fmt: skip


SHOWN_BY = {"tracking": "readings", "torque": "torques", "load": "second encoder"}


def plan_document(plan: MotionPlan) -> Document:
    """The report of planned motions, on a terminal."""
    log = plan.log
    shown = [one for one in plan.limits if one.size is not None]
    alone = sum(not one.alike for one in shown)
    titles = ("effect", "where", "shown by", "detectable from", "not distinguished from")
    rows = [_limit_row(group, log.joints) for group in _groups(plan)]
    sizes = Table([Column(title, brief=title) for title in titles], rows, printed=len(rows))
    lead = (
        f"Of {len(plan.limits)} possible faults, these motions would show {len(shown)}, and distinguish {alone} of them"
        " from the others."
    )
    sections = [Section("Smallest sizes", [sizes]), Section("Motions to add", [Notes(plan.next_motions, "steps", 8)])]
    return Document(log.name, "planned", headline(log), lead, "", [], sections, prints_lead=True)


def _groups(plan: MotionPlan) -> list[list[MotionLimit]]:
    """Detection limits, effect by effect; a row for each of its numbers."""
    groups: dict[tuple[str, str, str], list[MotionLimit]] = {}
    for one in plan.limits:
        groups.setdefault((one.at.effect.name, one.at.effect.rows, one.number.name), []).append(one)
    return list(groups.values())


def _limit_row(group: Sequence[MotionLimit], joints: Sequence[str]) -> tuple[str, ...]:
    """An effect at all of its locations: detectable sizes at the best and at the worst of them."""
    effect = group[0].at.effect
    places = [one.at.where for one in group]
    where = "all joints" if list(joints) == places else ", ".join(places)
    never = [one.at.where for one in group if one.size is None]
    sizes = sorted((one.size for one in group if one.size is not None), reverse=effect.name == "speed_limit")
    number = group[0].number
    unit, scale = UNITS.get(number.unit, (number.unit, 1.0))
    shown = list(dict.fromkeys(f"{float(f'{scale * size:.2g}'):g}" for size in (*sizes[:1], *sizes[-1:])))
    below = "below " if effect.name == "speed_limit" else ""
    size = below + with_unit(" to ".join(shown), unit) if shown else "never"
    size += f"; never at {', '.join(never)}" if never and shown else ""
    alike: dict[str, dict[str, None]] = {}
    for one in group:
        for rival in one.alike:
            alike.setdefault(spoken(rival.effect.name), {})[one.at.where] = None
    rivals = [name if list(at) == places else f"{name} at {', '.join(at)}" for name, at in alike.items()]
    name = spoken(effect.name) + (f" ({number.name})" if number is not effect.numbers[0] else "")
    return name, where, SHOWN_BY[effect.rows], size, "; ".join(rivals)
