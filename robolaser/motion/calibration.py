"""A model of a moving arm with the effects that the user names: their numbers, and errors on held-out motions."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Progress
from robolaser.errors import EffectError, UsageError, near
from robolaser.motion.effect import At
from robolaser.motion.effects import library_of
from robolaser.motion.gap import KindGap, at_flange
from robolaser.motion.kind_diagnoses import parts_of
from robolaser.motion.kind_diagnosis import KindDiagnosis
from robolaser.motion.log import MotionLog
from robolaser.motion.selection import EffectSearch, SelectedEffect, chosen


@final
@dataclass(frozen=True, eq=False)
class MotionFit:
    """Fitted effects and the remaining errors."""

    log: MotionLog
    parts: tuple[KindDiagnosis, ...]
    findings: tuple[SelectedEffect, ...]
    gap_mm: dict[str, Any]  # the tracking error at the flange, as JSON files give it
    levers_mm: Array  # motion of the flange with each joint, (j,) [mm/rad]
    seconds: float

    @classmethod
    def of(
        cls,
        log: MotionLog,
        parts: Sequence[KindDiagnosis],
        findings: Sequence[SelectedEffect],
        seed: int,
        seconds: float,
    ) -> "MotionFit":
        """From the diagnosis of each kind of rows."""
        gap_mm: dict[str, Any] = dict.fromkeys(("nominal", "calibrated", "after", "noise_floor"))
        gap_mm["after_ci95"], levers_mm = [None, None], np.zeros(len(log.joints))
        for part in parts:
            if part.gap.kind == "tracking":
                gap_mm, levers_mm = at_flange(log, part.gap, part.before, part.after, seed)
        return cls(log, tuple(parts), tuple(findings), gap_mm, levers_mm, seconds)

    @property
    def gaps(self) -> list[KindGap]:
        """Errors of each kind of rows."""
        return [part.gap for part in self.parts]


def calibrate_motion(
    log: MotionLog, effects: Sequence[str] = (), seed: int = 1, progress: Progress | None = None
) -> MotionFit:
    """Find the numbers of effects.

    Args:
        log: Commands, encoders and torques along time.
        effects: As NAME[:WHERE]; without WHERE, at every joint that can show it.
        seed: Of the resampling of runs.
        progress: Called with the current step and its finished share.

    Raises:
        UsageError: There is no effect of that name, or not at that location.
        EffectError: These rows do not show it.
        DataError: Nothing can be compared.
    """
    began = time.monotonic()
    requested = [(name, where) for name, _, where in (text.partition(":") for text in effects)]
    library = library_of([name for name, _ in requested])
    for name, where in requested:
        own = {one.site for one in library if one.name == name}
        sites = [*(log.joints if "joint" in own else ()), *sorted(own - {"joint"})]
        if where and where not in sites:
            raise UsageError(f"{name} has no location '{where}'.{near(where, sites)}")

    def is_requested(at: At) -> bool:
        """Whether its name was given: of several forms the simplest one, or another one by its site."""
        locations = ("", at.where) if not at.effect.form else (at.effect.site,)
        return any(at.effect.name == name and where in locations for name, where in requested)

    def searching(candidates: Sequence[At], *_: object) -> EffectSearch:
        return chosen(list(filter(is_requested, candidates)))

    parts, missing, _ = parts_of(log, library, searching, progress or (lambda what, share: None))
    findings = merged([finding for part in parts for finding in part.findings])
    found = [one.at for one in findings]
    for name, where in requested:
        if not any(at.effect.name == name and where in ("", at.where) for at in found):
            reason = missing.get(name, "with it, the error on unseen motions is no smaller")
            raise EffectError(f"{name}{f' at {where}' if where else ''} cannot be found: {reason}.")
    return MotionFit.of(log, parts, findings, seed, time.monotonic() - began)


def merged(findings: Sequence[SelectedEffect]) -> list[SelectedEffect]:
    """Findings in which an effect that several joints show at one location, a clock, is one entry."""
    groups: dict[tuple[str, ...], list[SelectedEffect]] = {}
    for one in findings:
        groups.setdefault((one.at.effect.rows, *one.at.pair), []).append(one)
    entries = []
    for group in groups.values():
        best = max(group, key=lambda one: one.probability)
        numbers = {name: number for one in group for name, number in one.numbers.items()}
        common = [one.numbers["delay"] for one in group if "delay" in one.numbers]
        if len(common) > 1:
            weights = np.array([1.0 / max(deviation, 1e-9) ** 2 for _, deviation, _ in common])
            delays = np.array([delay for delay, _, _ in common])
            numbers["delay"] = (float(weights @ delays / weights.sum()), float(np.ptp(delays) / 2.0), "s")
        entries.append(replace(best, numbers=numbers, gained=np.sum([one.gained for one in group], axis=0)))
    return entries
