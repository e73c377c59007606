"""The effects on moving arms, one file for each group of causes."""

from collections.abc import Sequence

from robolaser.errors import UsageError, near
from robolaser.motion.effect import MotionEffect
from robolaser.motion.effects.dynamics import DYNAMICS
from robolaser.motion.effects.friction import FRICTION
from robolaser.motion.effects.servo import TRACKING
from robolaser.motion.effects.transmission import TRANSMISSION

MOTION_EFFECTS: tuple[MotionEffect, ...] = (*TRACKING, *FRICTION, *DYNAMICS, *TRANSMISSION)
"""Everything that a diagnosis of a moving arm can name; in each kind of rows, clocks come first."""


def library_of(effects: Sequence[MotionEffect | str] | None, without: Sequence[str] = ()) -> list[MotionEffect]:
    """The effects that are asked for: all by default, by name or as such, less some names.

    Raises:
        UsageError: There is no effect of a name.
    """
    names = list(dict.fromkeys(one.name for one in MOTION_EFFECTS))
    asked = [one if isinstance(one, str) else one.name for one in effects or ()]
    for name in (*asked, *without):
        if name not in names:
            raise UsageError(f"There is no effect '{name}' on moving arms.{near(name, names)}")
    own = [one for one in effects or () if not isinstance(one, str)]
    chosen = MOTION_EFFECTS if effects is None else [one for one in MOTION_EFFECTS if one.name in asked]
    return [one for one in dict.fromkeys([*chosen, *own]) if one.name not in without]
