"""The numbers of effects that a user says are at work on a moving arm."""

import time
from collections.abc import Sequence

from robolaser.arrays import Progress
from robolaser.errors import EffectError, near
from robolaser.motion.diagnosis import library_of
from robolaser.motion.effect import At
from robolaser.motion.fit import MotionFit, merged
from robolaser.motion.log import MotionLog
from robolaser.motion.parts import parts_of
from robolaser.motion.selection import Search, chosen


def calibrate_motion(
    log: MotionLog, effects: Sequence[str] = (), seed: int | None = None, progress: Progress | None = None
) -> MotionFit:
    """Find the numbers of effects.

    Args:
        log: Commands, encoders and torques along time.
        effects: By NAME[:WHERE]; at every joint that can show it where no place is given.
        seed: Of the resampling of runs.
        progress: Called with the current step and its finished share.

    Raises:
        UsageError: There is no effect of that name.
        EffectError: It has no such place, or these rows do not show it.
        DataError: Nothing can be compared.
    """
    began = time.monotonic()
    asked = [(name, where) for name, _, where in (text.partition(":") for text in effects)]
    library = library_of([name for name, _ in asked])
    sites = [*log.joints, *(one.site for one in library if one.site != "joint")]
    for name, where in asked:
        if where and where not in sites:
            raise EffectError(f"{name} has no place '{where}'.{near(where, sites)}")

    def searching(candidates: Sequence[At], least_share: float, start: tuple[At, ...]) -> Search:
        return chosen([at for at in candidates if not at.effect.form and _is_asked(at, asked)])

    parts, missing, _ = parts_of(log, library, searching, progress or (lambda what, share: None))
    findings = merged([finding for part in parts for finding in part.findings])
    found = [one.at for one in findings]
    for name, where in asked:
        if not any(at.effect.name == name and where in ("", at.where) for at in found):
            reason = missing.get(name, "with it, the error on unseen motions is no smaller")
            raise EffectError(f"{name}{f' at {where}' if where else ''} cannot be found: {reason}.")
    return MotionFit.of(log, parts, findings, seed, time.monotonic() - began)


def _is_asked(at: At, asked: Sequence[tuple[str, str]]) -> bool:
    return any(at.effect.name == name and where in ("", at.where) for name, where in asked)
