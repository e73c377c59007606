"""Tables of a diagnosis: each row a value with its error, and what to beware of."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import final

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.diagnosis.result import DetectionLimit, Diagnosis, Estimate
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.joints import moving_joints
from robolaser.report.diagnosis.advice import beside, caveats, doubt
from robolaser.report.digits import measured, millimetres, plain

SMALL = 1e-3
"""Probabilities are not told apart below this, nor above its complement."""


@final
@dataclass(frozen=True)
class EffectRow:
    """An effect that was found.

    Attributes:
        effect: Its name.
        where: Its place.
        meaning: In a few words.
        numbers: Name of each, value with error and unit, and what to beware of with it.
        probability: Of the effect.
        closes: The gap before and after.
        without: The gap when this one alone is taken out again.
        caveat: What to beware of.
    """

    effect: str
    where: str
    meaning: str
    numbers: Sequence[tuple[str, str, str]]
    probability: str
    closes: str
    without: str
    caveat: str


@final
@dataclass(frozen=True)
class RivalRow:
    """An effect that could stand in another's place."""

    effect: str
    where: str
    meaning: str
    numbers: Sequence[tuple[str, str, str]]
    gap: str
    instead_of: str
    caveat: str


@final
@dataclass(frozen=True)
class PlaceRow:
    """A place of the gap: its share in per cent, and how likely chance alone would show as much."""

    site: str
    coordinate: str
    share: float
    chance: str


def effect_rows(diagnosis: Diagnosis) -> list[EffectRow]:
    """The effects found, most important first."""
    return [
        EffectRow(
            effect=found.candidate_effect.effect.name,
            where=found.candidate_effect.where,
            meaning=found.candidate_effect.effect.title,
            numbers=[(name, with_error(number), doubt(number)) for name, number in found.parameters.items()],
            probability=percent(found.probability),
            closes=f"{millimetres(found.gap_before_m)} → {millimetres(found.gap_after_m)}",
            without=millimetres(found.gap_without_m),
            caveat="; ".join(caveats(diagnosis, found)),
        )
        for found in diagnosis.findings
    ]


def rival_rows(diagnosis: Diagnosis) -> list[RivalRow]:
    """What else could be the cause, as far as these poses can tell."""
    return [
        RivalRow(
            effect=rival.candidate_effect.effect.name,
            where=rival.candidate_effect.where,
            meaning=rival.candidate_effect.effect.title,
            numbers=[(name, with_error(number), doubt(number)) for name, number in rival.parameters.items()],
            gap=millimetres(rival.gap_m),
            instead_of=at(found.candidate_effect),
            caveat=beside(found, rival),
        )
        for found in diagnosis.findings
        for rival in found.alternatives
    ]


def place_rows(diagnosis: Diagnosis) -> list[PlaceRow]:
    """Where the gap lies."""
    return [PlaceRow(lies.site, lies.coordinate, 100 * lies.share, _chance(lies.p_value)) for lies in diagnosis.where]


def limit_rows(diagnosis: Diagnosis) -> Iterator[tuple[str, str, str]]:
    """Effects that were looked for and not found: name, meaning, and how small they must be at each place."""
    by_effect = sorted(diagnosis.limits, key=lambda limit: limit.candidate_effect.effect.name)
    for kind, limits in groupby(by_effect, key=lambda limit: limit.candidate_effect.effect):
        yield kind.name, kind.title, ", ".join(map(_less, _of_interest(tuple(limits))))


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


def joint_units(dataset: Dataset) -> Mapping[str, str]:
    """SI unit of each moving joint."""
    robot = dataset.robot
    if robot is None:
        return {}
    return {name: "m" if robot.prismatic[robot.joints.index(name)] else "rad" for name in moving_joints(dataset.robot)}


def with_error(number: Estimate) -> str:
    """A number as people read it."""
    return measured(number.value, np.nan if number.std is None else number.std, number.unit)


def percent(share: float) -> str:
    """A probability, never quite none and never quite all."""
    if share > 1 - SMALL:
        return "> 99.9 %"
    return "< 0.1 %" if share < SMALL else f"{100 * share:.3g} %"


def at(candidate_effect: CandidateEffect) -> str:
    """An effect and its place."""
    return str(candidate_effect)


def _chance(p: float) -> str:
    return "< 10⁻⁶" if p < 1e-6 else plain(p, "", 2)


def _less(limit: DetectionLimit) -> str:
    if limit.size is None:
        return f"{limit.candidate_effect.where}: these poses show no size of it"
    return f"{limit.candidate_effect.where} < {plain(limit.size, limit.unit, 2)}"


def _of_interest(limits: Sequence[DetectionLimit]) -> Sequence[DetectionLimit]:
    """Those with a size first."""
    return sorted(limits, key=lambda limit: limit.size is None)
