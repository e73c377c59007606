"""Tables of a diagnosis: values with their errors and caveats."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import final

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.diagnosis.cause_words import noun
from robolaser.diagnosis.result import Alternative, CauseClass, DetectionLimit, Diagnosis, Estimate, Finding
from robolaser.model.effects.joints import moving_joints
from robolaser.report.diagnosis.advice import caveats, comparison, doubt
from robolaser.report.digits import measured, millimetres, percent, plain

MOST_MEMBERS = 8
"""Members of a class that are listed."""


@final
@dataclass(frozen=True)
class EffectRow:
    """An effect that was found, or one that could stand in its place.

    Attributes:
        effect: Its name.
        where: Its site.
        meaning: In a few words.
        values: Name of each parameter, value with error and unit, and the caveat about it.
        cells: What further columns say.
        caveat: Of the whole.
    """

    effect: str
    where: str
    meaning: str
    values: Sequence[tuple[str, str, str]]
    cells: Sequence[str]
    caveat: str


@final
@dataclass(frozen=True)
class SiteRow:
    """A site of the gap: its share in per cent, and the p value of finding as much by chance."""

    site: str
    coordinate: str
    share: float
    p_value: str


def class_rows(diagnosis: Diagnosis) -> list[tuple[str, str, str, str, str]]:
    """Classes of causes: name, meaning, probability, gap without and with it, and its members."""
    return [
        (
            one.name.replace("_", " "),
            _meaning(one),
            percent(one.probability),
            "" if one.gap_without_m is None else f"{millimetres(one.gap_without_m)} → {millimetres(one.gap_with_m)}",
            ", ".join(f"{member} {percent(p)}" for member, p in one.members[:MOST_MEMBERS])
            + (f" and {more} more" if (more := len(one.members) - MOST_MEMBERS) > 0 else ""),
        )
        for one in diagnosis.classes
    ]


def _meaning(one: CauseClass) -> str:
    """What a class is, unless its name says as much."""
    words = noun(one.name)
    said = "" if words == f"the {one.name.replace('_', ' ')}" else words
    return f"{said}, at {one.site}" if one.site else said


def effect_rows(diagnosis: Diagnosis) -> list[EffectRow]:
    """The effects found, most important first: probability, gap before and after, gap without this one."""
    return [
        _row(
            found,
            (
                percent(found.probability),
                f"{millimetres(found.gap_before_m)} → {millimetres(found.gap_after_m)}",
                millimetres(found.gap_without_m),
            ),
            "; ".join(caveats(diagnosis, found)),
        )
        for found in diagnosis.findings
    ]


def alternative_rows(diagnosis: Diagnosis) -> list[EffectRow]:
    """What else could be the cause, as far as these poses can tell: the gap with it, and what it would replace."""
    return [
        _row(other, (millimetres(other.gap_m), str(found.candidate_effect)), comparison(found, other))
        for found in diagnosis.findings
        for other in found.alternatives
    ]


def _row(one: Finding | Alternative, cells: Sequence[str], caveat: str) -> EffectRow:
    effect = one.candidate_effect.effect
    values = [(name, with_error(number), doubt(number)) for name, number in one.parameters.items()]
    return EffectRow(effect.name, one.candidate_effect.where, effect.title, values, cells, caveat)


def site_rows(diagnosis: Diagnosis) -> list[SiteRow]:
    """Where the gap lies."""
    return [SiteRow(lies.site, lies.coordinate, 100 * lies.share, _chance(lies.p_value)) for lies in diagnosis.where]


def limit_rows(diagnosis: Diagnosis) -> Iterator[tuple[str, str, list[str]]]:
    """Effects that were looked for and not found: name, meaning, and how small they must be at each place."""
    by_effect = sorted(diagnosis.limits, key=lambda limit: limit.candidate_effect.effect.name)
    for kind, limits in groupby(by_effect, key=lambda limit: limit.candidate_effect.effect):
        yield kind.name, kind.title, _less(tuple(limits))


def untestable_rows(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """What could not be tested, each reason once: effects, and why."""
    effects: dict[str, list[str]] = {}
    for name, reason in diagnosis.not_testable.items():
        effects.setdefault(reason, []).append(name)
    return [(", ".join(names), reason) for reason, names in effects.items()]


def pose_table(diagnosis: Diagnosis) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
    """Next poses: joints as columns, values for people as rows."""
    joints = list(dict.fromkeys(joint for pose in diagnosis.next_poses for joint in pose))
    units = joint_units(diagnosis.dataset)
    return joints, [
        [plain(round(pose[joint], 5), units.get(joint, "rad")) if joint in pose else "" for joint in joints]
        for pose in diagnosis.next_poses
    ]


def gross_rows(diagnosis: Diagnosis) -> Iterator[tuple[int, str, str, str]]:
    """Gross errors: data row of points.csv from 1, pose, point, and the shot where shots were repeated."""
    points, poses = diagnosis.dataset.points, diagnosis.dataset.poses
    for row in diagnosis.outliers.tolist():
        repeat = "" if points.repeat is None else str(points.repeat[row])
        yield row + 1, poses.names[points.pose[row]], points.names[row], repeat


def validation_rows(diagnosis: Diagnosis) -> Iterator[tuple[str, Sequence[str], str]]:
    """Other data of the same arm: name, the error step by step, and what did not carry over."""
    for one in diagnosis.validation:
        errors = (one.nominal_m, one.calibrated_m, one.after_m, one.noise_floor_m)
        yield one.dataset, [millimetres(error) for error in errors], "; ".join(one.remarks)


def joint_units(dataset: Dataset) -> Mapping[str, str]:
    """SI unit of each moving joint."""
    robot = dataset.robot
    if robot is None:
        return {}
    return {name: "m" if robot.prismatic[robot.joints.index(name)] else "rad" for name in moving_joints(dataset.robot)}


def with_error(number: Estimate) -> str:
    """A number as people read it."""
    return measured(number.value, np.nan if number.std is None else number.std, number.unit)


def _chance(p: float) -> str:
    return "< 10⁻⁶" if p < 1e-6 else plain(p, "", 2)


def _less(limits: Sequence[DetectionLimit]) -> list[str]:
    """A line for each place with a limit, and one for those without."""
    lines = [_limit(one) for one in limits]
    for is_imitated, why in ((True, "in the model as an effect found"), (False, "cannot be seen in these poses")):
        unseen = [one.candidate_effect.where for one in limits if one.size is None and one.is_imitated == is_imitated]
        lines += [f"{', '.join(unseen)}: {why}"] if unseen else []
    return [*filter(None, lines)]


def _limit(one: DetectionLimit) -> str:
    if one.size is None:
        return ""
    said = [f"{one.candidate_effect.where} < {plain(one.size, one.unit, 2)}"]
    if one.at_tool_m is not None:
        said.append(f"{plain(one.at_tool_m, 'm', 2)} at the tool")
    if one.rival is not None:
        size = "" if one.identifiable is None else plain(one.identifiable, one.unit, 2)
        said.append(f"above {size} distinguishable from {one.rival}" if size else f"indistinguishable from {one.rival}")
    return "; ".join(said)
