"""Why a moving arm does not follow its model: which effects, where, and how far the gap shrinks on unseen motions."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.special import bdtrc

from robolaser.arrays import Array, Ints, Progress
from robolaser.estimation.certainty import LIKELY
from robolaser.motion.calibration import MotionFit, merged
from robolaser.motion.checking import comparable
from robolaser.motion.effect import MOVES_RAD
from robolaser.motion.effects import library_of
from robolaser.motion.gap import FEWEST_RUNS, root_mean_squares, root_mean_squares_of_runs
from robolaser.motion.kind_diagnoses import parts_of
from robolaser.motion.kind_diagnosis import KindDiagnosis
from robolaser.motion.log import MotionLog, filled
from robolaser.motion.misread import misread
from robolaser.motion.selection import SelectedEffect, search

OF_PULLS = ("offset", "scale", "droop")  # effects of a servo that an unknown torque imitates


@final
@dataclass(frozen=True, eq=False)
class Place:
    """A location of the gap, or of its remaining part."""

    site: str
    coordinate: str
    share: float
    p_value: float  # of noise alone exceeding its size in so many of the runs


@final
@dataclass(frozen=True, eq=False)
class MotionDiagnosis:
    """The result of a diagnosis."""

    fit: MotionFit  # with the effects found
    verdict: str
    places: tuple[Place, ...]
    not_testable: dict[str, str]
    remarks: tuple[str, ...]


def diagnose_motion(
    log: MotionLog,
    effects: Sequence[str] | None = None,
    without: Sequence[str] = (),
    seed: int = 1,
    progress: Progress | None = None,
) -> MotionDiagnosis:
    """Find the effects that separate a moving arm from its model.

    By default all of `MOTION_EFFECTS` may be at work. The seed is of the resampling of runs.

    Raises:
        DataError: Nothing can be compared: there are neither commands nor torques nor a second encoder.
        UsageError: There is no effect of that name.
    """
    began, announce = time.monotonic(), progress or (lambda what, share: None)
    library = library_of(effects, without)
    other = misread(log) if not comparable(log)["torque"] else None
    read = other.of(log) if other else log
    parts, missing, remarks = parts_of(read, library, search, announce)
    parts = _beside_torques(parts)
    tested = {at.effect.name for part in parts for at in (*part.candidates, *(one.at for one in part.shown))}
    missing = {name: reason for name, reason in missing.items() if name not in tested}
    verdicts = [part.verdict for part in parts]
    verdict = "unexplained" if "unexplained" in verdicts else "explained" if "explained" in verdicts else "no_gap"
    findings = [] if verdict == "no_gap" else merged([finding for part in parts for finding in part.shown])
    named = [part.as_named for part in parts]
    restated = [other.restated(part) if other and part.gap.kind == "torque" else part for part in named]
    if other:
        first = [one for part in restated if part.gap.kind == "torque" for one in part.findings]
        findings = [*first, *(one for one in findings if one.at.pair not in [own.at.pair for own in first])]
        verdict = "explained" if verdict == "no_gap" else verdict
    findings.sort(key=lambda one: one.without.score, reverse=True)
    places = [] if verdict == "no_gap" else _places(restated if verdict == "explained" else parts, log.joints, verdict)
    fit = MotionFit(read, tuple(restated), tuple(findings), seed, time.monotonic() - began)
    return MotionDiagnosis(fit, verdict, tuple(places), missing, (*remarks, *_remarks(log)))


def _beside_torques(parts: Sequence[KindDiagnosis]) -> list[KindDiagnosis]:
    """The parts, in which effects of servos are likely at most where torques have an unknown cause.

    A spring or a hose that pulls at a joint makes a servo of finite stiffness sink, or move too far, in its own way.
    """
    pulled = {j for part in parts if part.gap.kind == "torque" for j in np.flatnonzero(part.is_open).tolist()}

    def doubted(one: SelectedEffect) -> SelectedEffect:
        is_pull = one.at.effect.rows == "tracking" and one.at.effect.name in OF_PULLS and one.at.joint in pulled
        return replace(one.doubted(LIKELY), may_be_pulled=True) if is_pull else one

    return [replace(part, findings=tuple(map(doubted, part.findings))) for part in parts]


def _places(parts: Sequence[KindDiagnosis], joints: Sequence[str], verdict: str) -> list[Place]:
    """Joints by their share of the gap, or of the remaining error: of the first kind of rows that has one."""
    for part in parts:
        if part.verdict != verdict:
            continue
        gap = part.gap
        errors = part.left if verdict == "unexplained" else part.before
        error = root_mean_squares(errors)
        excess = np.nan_to_num(np.maximum(error**2 - gap.noise_floor**2, 0.0))
        if excess.sum() <= 0.0:
            continue
        places = [
            Place(
                name,
                f"{what} of {name}" if (what := part.places.get(name, "")) not in ("", "time") else what,
                round(float(share), 4),
                _chance(errors[:, j], part.run, gap.noise_floor[j]),
            )
            for j, (name, share) in enumerate(zip(joints, excess / excess.sum(), strict=True))
        ]
        return sorted((place for place in places if place.share > 0.01), key=lambda place: -place.share)
    return []


def _chance(errors: Array, run: Ints, noise: float) -> float:
    """P of as many runs with more than the noise, where each has more or less by chance (a sign test)."""
    sizes = root_mean_squares_of_runs(errors, run)
    sizes = sizes[np.isfinite(sizes)]
    return float(bdtrc((sizes > noise).sum() - 1.0, len(sizes), 0.5))


def _remarks(log: MotionLog) -> list[str]:
    remarks = []
    read = log.as_read
    for quantity, what in (("q", "Readings"), ("tau", "Torques"), ("load", "Second readings")):
        held = np.isfinite(getattr(log, quantity)).sum(axis=0) > np.isfinite(getattr(read, quantity)).sum(axis=0)
        if held.any():
            where = "" if held.all() else f" of {', '.join(np.array(log.joints)[held])}"
            remarks.append(f"{what}{where} are read more slowly than rows are written: those that only repeat the row"
                           " above are left out.")  # fmt: skip
    same = np.diff(log.run) == 0
    step = np.diff(log.time_s)[same]
    if len(step) and np.percentile(step, 99) > 1.5 * np.median(step):
        remarks.append("The time between rows varies by more than half: commands between rows are interpolated.")
    commands = log.command[:, log.has("command")]
    if commands.size and all((np.ptp(filled(commands[rows]), axis=0) < MOVES_RAD).all() for rows in log.rows_of_runs):
        remarks.append("The arm was commanded to stand still in all series: only constant errors can show.")
    if len(log.series) < FEWEST_RUNS:
        remarks.append(
            f"Only {len(log.series)} series: blocks of rows are held out, so differences between series are not tested."
        )
    return remarks
