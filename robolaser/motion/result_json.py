"""A diagnosis of a moving arm as diagnosis.json, and in a sentence."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from robolaser.calibration.misread import MISREAD
from robolaser.calibration.saved import CALIBRATION, DIAGNOSIS
from robolaser.estimation.certainty import CERTAIN, EVEN
from robolaser.motion.calibration import MotionFit
from robolaser.motion.diagnosis import MotionDiagnosis
from robolaser.motion.effect import At
from robolaser.motion.gap import KindGap
from robolaser.motion.kind_diagnosis import FOLLOWS_RAD, FOLLOWS_SHARE, IS_NOISE
from robolaser.motion.selection import SelectedEffect

NAMED = 3  # effects, and joints of each, that the sentence names
ERRORS = {"tracking": "the tracking error", "torque": "the torque error", "load": "the encoders' difference"}


def motion_json(found: MotionDiagnosis) -> dict[str, Any]:
    """The contents of diagnosis.json."""
    return {
        **_errors(found.fit, DIAGNOSIS),
        "verdict": found.verdict,
        "sentence": sentence(found),
        "where": [asdict(one) | {"coordinate": one.coordinate or None} for one in found.places],
        "effects": [_effect(one, found.fit) for one in found.fit.findings],
        "kinds": kinds_json(found.fit),
        "classes": _classes(found),
        "not_testable": [{"effect": name, "reason": reason} for name, reason in sorted(found.not_testable.items())],
        "next_poses": [],
        "next_motions": next_motions(found),
        "noise_remarks": list(found.remarks),
    }


def motion_calibration_json(fit: MotionFit, seed: int) -> dict[str, Any]:
    """The contents of calibration.json: the numbers of the requested effects."""
    robot, after = fit.log.robot, fit.gap_mm["after"]
    return {
        **_errors(fit, CALIBRATION),
        "algorithm": "least squares",
        "seed": seed,
        "parameters": {},
        "unidentifiable": [],
        "model": {"sensor": "motion", "robot": robot.name, "flange": robot.flange, "joints": list(fit.log.joints),
                  "gravity": list(robot.gravity)},
        "effects": [_numbers(one) for one in fit.findings],
        **dict.fromkeys(("max_m", "axis_max_m", "evaluations")),
        "held_out_rms_m": None if after is None else after / 1e3,
    }  # fmt: skip


def _errors(fit: MotionFit, form: str) -> dict[str, Any]:
    """The keys of both files."""
    return {
        "format": form,
        "dataset": fit.log.name,
        "kind": "motion",
        "gap_mm": fit.gap_mm,
        "step_s": fit.log.step_s,
        "rows": [_rows(gap, fit.log.joints) for gap in fit.gaps],
        "objective_m2": None,
        "rms_m": None,
        "seconds": round(fit.seconds, 2),
    }


def _rows(gap: KindGap, joints: Sequence[str]) -> dict[str, Any]:
    names = ("nominal", "calibrated", "after", "noise_floor")
    there = np.flatnonzero(np.isfinite(gap.calibrated)).tolist()
    return {
        "kind": gap.kind,
        "rows": gap.count,
        "unit": gap.unit,
        **{name: gap.whole(name) for name in names},
        "joints": {joints[j]: {name: float(getattr(gap, name)[j]) for name in names} for j in there},
    }


def _without(fit: MotionFit, findings: Sequence[SelectedEffect]) -> float | None:
    """The gap at the flange without some effects, as if their contributions were independent [mm]."""
    if fit.gap_mm["after"] is None:
        return None
    gained = [one.gained for one in findings if one.at.effect.rows == "tracking"]
    return float(np.sqrt(fit.gap_mm["after"] ** 2 + np.nansum(sum(gained) * fit.levers_mm**2)))


def _effect(one: SelectedEffect, fit: MotionFit) -> dict[str, Any]:
    return _numbers(one) | {
        "probability": round(one.probability, 4),
        "gap_mm_before": fit.gap_mm["calibrated"],
        "gap_mm_after": fit.gap_mm["after"],
        "gap_mm_without": _without(fit, [one]),
        "indistinguishable_from": [rival.pair for rival in one.rivals],
    }


def _numbers(one: SelectedEffect) -> dict[str, Any]:
    return {
        "effect": one.at.effect.name,
        "where": one.at.where,
        "rows": one.at.effect.rows,
        "parameters": {
            name: {"value": value, "std": deviation if np.isfinite(deviation) else None, "unit": unit}
            for name, (value, deviation, unit) in one.numbers.items()
            if np.isfinite(value)
        },
    }


def kinds_json(fit: MotionFit) -> list[dict[str, Any]]:
    """Effects with all of their locations, as in JSON files."""
    return [
        _together(group, fit, "name") | {"effect": name, "where": [one.at.where for one in group]}
        for name, group in _groups(fit, "name").items()
    ]


def _groups(fit: MotionFit, by: str) -> dict[str, list[SelectedEffect]]:
    groups: dict[str, list[SelectedEffect]] = {}
    for one in fit.findings:
        groups.setdefault(getattr(one.at.effect, by), []).append(one)
    return groups


def _together(group: Sequence[SelectedEffect], fit: MotionFit, by: str) -> dict[str, Any]:
    return {"probability": round(_at_least_one(group, by), 4), "gap_mm_without": _without(fit, group)}


def _classes(found: MotionDiagnosis) -> list[dict[str, Any]]:
    after = found.fit.gap_mm["after"]
    classes = [
        {
            "class": name,
            **_together(group, found.fit, "cause"),
            "gap_mm_with": after,
            "members": [
                {"effect": one.at.effect.name, "where": one.at.where, "probability": round(one.probability, 4)}
                for one in group
            ],
            "credible_sets": [[one.at.pair, *(rival.pair for rival in one.rivals)] for one in group],
        }
        for name, group in _groups(found.fit, "cause").items()
    ]
    if found.verdict == "unexplained" and found.places:
        unknown = {"class": "unknown", "probability": MISREAD, "gap_mm_without": after, "gap_mm_with": after,
                   "members": [], "credible_sets": [], "site": found.places[0].site}  # fmt: skip
        classes.append(unknown)
    return sorted(classes, key=lambda one: -one["probability"])


def _at_least_one(group: Sequence[SelectedEffect], by: str) -> float:
    """Probability that at least one of some effects of one name or cause is present, or such a rival in its place.

    Where all have the same other rival and none is likelier, it is the same one at all locations, as with clocks. An
    unknown torque may be the cause of several effects at once.
    """

    def belongs(at: At) -> bool:
        return bool(getattr(at.effect, by) == getattr(group[0].at.effect, by))

    shared = set.intersection(*({rival.effect for rival in one.rivals if not belongs(rival)} for one in group))
    best = max(one.probability for one in group)
    if shared and (best <= EVEN or any(effect.site != "joint" for effect in shared)):
        return best
    each = [max(one.probability, 1.0 - one.none) if all(map(belongs, one.rivals)) else one.probability for one in group]
    pulled = max((p for one, p in zip(group, each, strict=True) if one.may_be_pulled), default=0.0)
    others = [p for one, p in zip(group, each, strict=True) if not one.may_be_pulled]
    return 1.0 - float(np.prod(1.0 - np.array([pulled, *others])))


def next_motions(found: MotionDiagnosis) -> list[str]:
    """Motions that would distinguish what these do not."""
    return motion_between((one.at, rival) for one in found.fit.findings for rival in one.rivals)


def motion_between(rivals: Iterable[tuple[At, At]]) -> list[str]:
    """Motions that would distinguish effects from rivals, each once with all joints."""
    joints: dict[frozenset[str], dict[str, None]] = {}
    for one, rival in rivals:
        joints.setdefault(frozenset((one.effect.name, rival.effect.name)), {})[one.where] = None
    return [
        f"{words} ({' or '.join(name.replace('_', ' ') for name in names)} at {', '.join(joints[frozenset(names)])})."
        for names, words in MOTIONS
        if frozenset(names) in joints
    ]


MOTIONS = (
    (("dead_time", "lag"), "Command steps: a dead time shifts the response, a lag smooths it"),
    (
        ("dead_zone", "play"),
        "Record an encoder behind the gear, or a camera: the servo's own encoder is inside its loop",
    ),
    (("droop", "offset"), "Hold configurations with the joint's load on either side"),
    (("droop", "lag"), "Repeat one motion with another payload"),
    (("clock_shift", "dead_time"), "Move the arm by hand during the recording: readings then follow no command"),
    (("coulomb_friction", "viscous_friction"), "Move the joint at several constant speeds"),
    (("coulomb_friction", "load_friction"), "Repeat one motion with another payload"),
    (("coulomb_friction", "stribeck_friction"), "Move the joint very slowly, too"),
    (("payload", "link_inertia"), "Turn the last joints with and without the tool"),
)


def sentence(found: MotionDiagnosis) -> str:
    """The verdict for a person."""
    gaps = "; ".join(_shrinks(gap) for gap in found.fit.gaps)
    if found.verdict == "no_gap":
        return f"There is no gap: the arm follows its model{_up_to(found.fit.gaps)}. On unseen motions: {gaps}."
    parts = "".join(f" {remark}" for part in found.fit.parts for remark in part.remarks)
    whole = "The gap is explained" if found.verdict == "explained" else "A part of the gap is explained"
    if not found.fit.findings:
        return f"The gap has a cause that is not in the library. On unseen motions: {gaps}.{parts}"
    groups = _groups(found.fit, "name")
    clauses = {name: _clause(group) for name, group in groups.items()}
    # certain effects first, and among these, those with a certain location
    sure = [(kind["probability"], max(one.probability for one in groups[kind["effect"]]), kind["effect"])
            for kind in kinds_json(found.fit)]  # fmt: skip
    sure.sort(key=lambda one: (one[0] < CERTAIN, one[1] < CERTAIN))
    phrases = [_surely(kind) + clauses[name] + _locations(groups[name], found.fit.log.joints) for kind, _, name in sure]
    causes = _first(phrases, "; ", ", listed below")
    rest = ""
    if found.verdict == "unexplained" and found.places:
        place = found.places[0]
        rest = f" The remaining error is at {place.site}{f' ({place.coordinate})' if place.coordinate else ''}."
    return f"{whole}: {causes}. On unseen motions: {gaps}.{rest}{parts}"


def _clause(group: Sequence[SelectedEffect]) -> str:
    """What is said of an effect; of clocks, what is said of each in its kind of rows."""
    return ", and ".join({one.at.effect.rows: one.at.effect.clause for one in group}.values())


def _up_to(gaps: Sequence[KindGap]) -> str:
    """The accuracy of an arm without a gap, where its errors are more than noise."""
    enough = {"tracking": f"{np.degrees(FOLLOWS_RAD):.1g}°", "torque": f"{100.0 * FOLLOWS_SHARE:.0f} % of the torques"}
    beyond = [gap.kind for gap in gaps if gap.whole("calibrated") > IS_NOISE * gap.whole("noise_floor")]
    closely = " and ".join(enough[kind] for kind in beyond if kind in enough)
    return f" to {closely}" if closely else ""


def _surely(probability: float) -> str:
    return "" if probability >= CERTAIN else "likely, " if probability > EVEN else "perhaps, "


def _first(names: Sequence[str], between: str, where: str = "") -> str:
    """The first of some names, and the number of further ones."""
    more = len(names) - NAMED
    return between.join(names[:NAMED]) + (f"{between.rstrip()} and {more} more{where}" if more > 0 else "")


def _locations(group: Sequence[SelectedEffect], joints: Sequence[str]) -> str:
    """The joints of an effect, after its clause; nothing where it is at none."""
    at = [
        " or ".join([one.at.where, *(rival.where for rival in one.rivals if rival.effect is one.at.effect)])
        for one in group
        if one.at.where in joints
    ]
    every = 1 < len(joints) == len(at)
    return f" ({'all joints' if every else _first(at, ', ')})" if at else ""


def _shrinks(gap: KindGap) -> str:
    scale, unit = (180.0 / np.pi, "°") if gap.unit == "rad" else (1.0, " Nm")
    before, after, noise = (scale * gap.whole(name) for name in ("calibrated", "after", "noise_floor"))
    was, left, floor = (f"{float(f'{error:.3g}'):g}{unit}" for error in (before, after, noise))
    change = f"falls from {was} to {left}" if after < before and left != was else f"is {was}"
    return f"{ERRORS[gap.kind]} {change} (noise {floor})"
