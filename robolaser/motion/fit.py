"""A model of a moving arm with effects: their numbers, and errors on motions that no fit has seen."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.motion.gap import AtFlange, KindGap
from robolaser.motion.log import MotionLog
from robolaser.motion.part import Finding, Part


@final
@dataclass(frozen=True, eq=False)
class MotionFit:
    """Effects with their numbers, and errors."""

    log: MotionLog
    gaps: tuple[KindGap, ...]
    findings: tuple[Finding, ...]
    at_flange: AtFlange | None
    left: Array | None  # tracking errors on unseen motions, (n, j) [rad]
    interval_mm: tuple[float, float] | None
    seconds: float

    @classmethod
    def of(
        cls, log: MotionLog, parts: Sequence[Part], findings: Sequence[Finding], seed: int | None, seconds: float
    ) -> "MotionFit":
        """From what each kind of rows says."""
        at_flange = interval = left = None
        for part in parts:
            if part.gap.kind == "tracking":
                at_flange = AtFlange.of(log, np.asarray(np.isfinite(part.after).any(axis=1)))
                left = part.after
                interval = at_flange.interval(left, log.run, np.random.default_rng(seed))
        return cls(log, tuple(part.gap for part in parts), tuple(findings), at_flange, left, interval, seconds)

    def gap(self, kind: str) -> KindGap | None:
        """Of the rows of a kind, if there are any."""
        return next((gap for gap in self.gaps if gap.kind == kind), None)


def merged(findings: Sequence[Finding]) -> list[Finding]:
    """One entry for an effect of the same rows at the same place that several joints show: clocks."""
    groups: dict[tuple[str, str, str], list[Finding]] = {}
    for one in findings:
        groups.setdefault((one.kind, one.at.effect.name, one.at.where), []).append(one)
    whole = []
    for group in groups.values():
        best = max(group, key=lambda one: one.judged.probability)
        numbers = {name: number for one in group for name, number in one.numbers.items()}
        common = [one.numbers["delay"] for one in group if "delay" in one.numbers]
        if len(common) > 1:
            weights = np.array([1.0 / max(deviation, 1e-9) ** 2 for _, deviation, _ in common])
            delays = np.array([delay for delay, _, _ in common])
            numbers["delay"] = (float(weights @ delays / weights.sum()), float(np.ptp(delays) / 2.0), "s")
        whole.append(replace(best, numbers=numbers, gained=np.sum([one.gained for one in group], axis=0)))
    return whole
