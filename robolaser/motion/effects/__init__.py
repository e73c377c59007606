"""The effects on moving arms, one file for each group of causes."""

import copyreg
from collections.abc import Sequence

from robolaser.errors import UsageError, near
from robolaser.motion.effect import MotionEffect
from robolaser.motion.effects.clocks import CLOCKS
from robolaser.motion.effects.dynamics import DYNAMICS
from robolaser.motion.effects.friction import FRICTION
from robolaser.motion.effects.servo import TRACKING
from robolaser.motion.effects.transmission import TRANSMISSION

MOTION_EFFECTS: tuple[MotionEffect, ...] = (*TRACKING, *CLOCKS, *FRICTION, *DYNAMICS, *TRANSMISSION)
"""All effects that a diagnosis of a moving arm can name; in each kind of rows, clocks come first."""


def _of_library(*key: str) -> MotionEffect:
    return next(one for one in MOTION_EFFECTS if (one.name, one.form, one.rows) == key)


copyreg.pickle(MotionEffect, lambda one: (_of_library, (one.name, one.form, one.rows)))  # functions are not pickled


def library_of(effects: Sequence[str] | None, without: Sequence[str] = ()) -> list[MotionEffect]:
    """The effects with given names, all by default, without some names; a `UsageError` if there is none of a name."""
    names = list(dict.fromkeys(one.name for one in MOTION_EFFECTS))
    chosen = names if effects is None else effects
    for name in (*chosen, *without):
        if name not in names:
            raise UsageError(f"There is no effect '{name}' on moving arms.{near(name, names)}")
    return [one for one in MOTION_EFFECTS if one.name in chosen and one.name not in without]
