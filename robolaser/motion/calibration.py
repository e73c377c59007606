"""A model of a moving arm with the effects that the user names: their numbers, and errors on held-out motions."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
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
    seed: int  # of the resampling of runs
    seconds: float

    @property
    def gaps(self) -> list[KindGap]:
        """Errors of each kind of rows."""
        return [part.gap for part in self.parts]

    @property
    def gap_mm(self) -> dict[str, Any]:
        """The tracking error at the flange, as JSON files give it."""
        return self._at_flange[0]

    @property
    def levers_mm(self) -> Array:
        """Motion of the flange with each joint, (j,) [mm/rad]."""
        return self._at_flange[1]

    @cached_property
    def _at_flange(self) -> tuple[dict[str, Any], Array]:
        for part in self.parts:
            if part.gap.kind == "tracking":
                return at_flange(self.log, part.gap, part.before, part.after, self.seed)
        nothing = dict.fromkeys(("nominal", "calibrated", "after", "noise_floor"))
        return {**nothing, "after_ci95": [None, None]}, np.zeros(len(self.log.joints))


def calibrate_motion(
    log: MotionLog, effects: Sequence[str] = (), seed: int = 1, progress: Progress | None = None
) -> MotionFit:
    """Find the numbers of effects, NAME[:WHERE] each; without WHERE, at every joint that can show it.

    The seed is of the resampling of runs.

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
    return MotionFit(log, tuple(parts), tuple(findings), seed, time.monotonic() - began)


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
