"""Tables of a diagnosis: values with their errors and caveats."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from robolaser.diagnosis.cause_words import named, noun, place, sentence_case, site_phrase, spoken
from robolaser.diagnosis.result import Alternative, CauseClass, Diagnosis, Estimate, Finding
from robolaser.estimation.certainty import CERTAIN
from robolaser.report.diagnosis.advice import UNDETERMINED, caveats, doubt
from robolaser.report.digits import measured, millimetres, percent, plain
from robolaser.report.document import Column, Table, TableCell

MOST_MEMBERS: Final = 8  # members of a class that are listed
MOST_CLASSES, MOST_EFFECTS = 3, 5  # lines of each on the terminal
FEW: Final = 8  # rows above which a table of details is collapsed
SURE: Final = Column("How sure", "wide", 42, "how sure")


def class_table(diagnosis: Diagnosis) -> Table:
    """Classes of causes: their probability, the gap without and with them, and their members."""
    rows = [
        (
            TableCell(spoken(one.name), below=[text] if (text := _meaning(one)) else []),
            ", ".join(f"{named(member)} {percent(p)}" for member, p in one.members[:MOST_MEMBERS])
            + (f" and {more} more" if (more := len(one.members) - MOST_MEMBERS) > 0 else ""),
            TableCell(f"{percent(one.probability)}{_without(one.gap_without_m)}", order=one.probability),
        )
        for one in diagnosis.classes
    ]
    columns = [Column("Class", "name", 30, "class"), Column("Possible causes"), SURE]
    if not _is_open(diagnosis):
        return Table(columns, rows, "Classes of causes")
    note = "A class can be certain where none of its members is."
    return Table(columns, rows, "Classes of causes", note, printed=MOST_CLASSES)


def _is_open(diagnosis: Diagnosis) -> bool:
    """Whether some effect is not certain by itself: then the classes come first."""
    return any(found.probability < CERTAIN for found in diagnosis.findings)


def _meaning(one: CauseClass) -> str:
    """The meaning of a class, unless it is its name."""
    words = noun(one.name)
    text = "" if words == f"the {spoken(one.name)}" else words
    return f"{text}, at {site_phrase(one.site)}" if one.site else text


def effect_table(diagnosis: Diagnosis) -> Table:
    """The effects found, most important first: probability, gap before and after, gap without this one."""
    columns = [
        Column("Effect", "name", 26, "effect"),
        Column("How large ± standard deviation", "number", brief="how large"),
        SURE,
    ]
    rows = [
        (
            *_effect(found),
            TableCell(
                f"{percent(found.probability)}{_without(found.gap_without_m)}",
                below=[f"added: {millimetres(found.gap_before_m)} → {millimetres(found.gap_after_m)}"],
                note="\n".join(caveats(found)),
                order=found.probability,
            ),
        )
        for found in diagnosis.findings
    ]
    note = "Each may have absorbed a part of the unexplained error." if diagnosis.verdict == "unexplained" else ""
    return Table(columns, rows, "Single effects" if _is_open(diagnosis) else "", note, printed=MOST_EFFECTS)


def alternative_table(diagnosis: Diagnosis) -> Table:
    """Alternatives that these poses do not exclude: the gap with each, and what it would replace."""
    columns = [
        Column("Alternative", "name", 26),
        Column("How large ± standard deviation", "number"),
        Column("How it compares", "wide", 42),
    ]
    rows = [
        (*_effect(other), f"instead of {named(found.candidate_effect)}: gap {millimetres(other.gap_m)}")
        for found in diagnosis.findings
        for other in found.alternatives
    ]
    note = "These poses cannot distinguish the alternatives from what was found."
    note += " The poses to measure next distinguish the least probable effect from its first alternative." * bool(
        diagnosis.next_poses
    )
    return Table(columns, rows, "Alternatives", note, fold=6)


def _without(gap_m: float | None) -> str:
    return "" if gap_m is None else f"; gap {millimetres(gap_m)} without it"


def _effect(one: Finding | Alternative) -> tuple[TableCell, TableCell]:
    """An effect, and its parameters, the clearest amplitude first."""
    effect = one.candidate_effect.effect
    amplitudes = {amplitude.name for amplitude in effect.amplitudes()}
    ordered = sorted(one.parameters.items(), key=lambda each: (each[0] not in amplitudes, -_clarity(each[1])))
    values = [
        f"{name.replace('_', ' ')} {_value(number)}" + (f" ({text})" if (text := doubt(number)) else "")
        for name, number in ordered
    ]
    return TableCell(sentence_case(named(one.candidate_effect)), below=[effect.title]), TableCell("\n".join(values))


def _value(number: Estimate) -> str:
    """A number with its error; an undetermined one with one digit."""
    if doubt(number) == UNDETERMINED:
        return plain(number.value, number.unit, 1)
    return measured(number.value, np.nan if number.std is None else number.std, number.unit)


def _clarity(number: Estimate) -> float:
    return abs(number.value) / number.std if number.std else 0.0


def site_table(diagnosis: Diagnosis) -> Table:
    """Locations of the gap."""
    is_rest = diagnosis.verdict == "unexplained"
    rows = [
        (
            place(part.site),
            part.coordinate,
            TableCell(f"{100 * part.share:.0f} %, p {_chance(part.p_value)}", share=100 * part.share, order=part.share),
        )
        for part in diagnosis.where
    ]
    columns = [Column("Site", "name", 24), Column("Depends on" if is_rest else "What is there"),
               Column(f"Share of the {'remaining error' if is_rest else 'gap'}, p value", "wide", 42)]  # fmt: skip
    note = (
        "Share: of the squared error beyond noise, the part that a smooth function of that coordinate at that site"
        " predicts on held-out poses."
        if is_rest
        else "Share: of the squared error beyond noise, the part that the effects found at that site remove."
    )
    return Table(columns, rows, note=note)


def pose_table(diagnosis: Diagnosis) -> Table:
    """Next poses: joints as columns, values for people as rows."""
    joints = list(dict.fromkeys(joint for pose in diagnosis.next_poses for joint in pose))
    robot = diagnosis.dataset.robot
    slides = {} if robot is None else dict(zip(robot.joints, robot.prismatic, strict=True))
    rows = [
        [str(number), *(plain(round(pose[joint], 5), "m" if slides.get(joint) else "rad") if joint in pose else ""
                        for joint in joints)]
        for number, pose in enumerate(diagnosis.next_poses, 1)
    ]  # fmt: skip
    return Table(
        [Column("Pose"), *map(Column, joints)],
        rows,
        note="Within the joint limits and without self-collision; obstacles are not checked.",
    )


def gross_table(diagnosis: Diagnosis) -> Table:
    """Gross errors: pose, point, the shot where shots were repeated, and the row, from 1, in the file of the sensor."""
    dataset, points, poses = diagnosis.dataset, diagnosis.dataset.points, diagnosis.dataset.poses
    shot = [] if points.repeat is None else [Column("Repeat")]
    seen_by = [dataset.sensors[number] for number in dataset.sensor_of_row[diagnosis.outliers]]
    rows = [
        (poses.names[points.pose[row]], points.names[row],
         *(() if points.repeat is None else (str(points.repeat[row]),)),
         sensor.file, str(int(np.searchsorted(sensor.rows, row)) + 1))
        for row, sensor in zip(diagnosis.outliers.tolist(), seen_by, strict=True)
    ]  # fmt: skip
    columns = [Column("Pose"), Column("Point"), *shot, Column("File"), Column("Row")]
    return Table(columns, rows, "Gross errors", "Excluded from everything above.", FEW)


def validation_table(diagnosis: Diagnosis) -> Table:
    """Other data of the same arm: name, the error step by step, and effects that did not transfer."""
    columns = [Column("Data set", "name", 24), Column("Nominal"), Column("Calibrated"), Column("With the effects"),
               Column("Noise alone"), Column("What does not transfer", "wide")]  # fmt: skip
    rows: list[Sequence[TableCell | str]] = [
        (one.dataset, "none" if one.nominal_m is None else millimetres(one.nominal_m),
         *map(millimetres, (one.calibrated_m, one.after_m, one.noise_floor_m)),
         TableCell(note="\n".join(one.remarks)))
        for one in diagnosis.validation
    ]  # fmt: skip
    note = (
        "Errors on held-out poses. Only base, target, tool and sockets were re-fitted; everything else is as found on"
        f" {diagnosis.dataset.name}."
    )
    return Table(columns, rows, note=note)


def _chance(p: float) -> str:
    return "< 10⁻⁶" if p < 1e-6 else f"= {plain(p, '', 2)}"
