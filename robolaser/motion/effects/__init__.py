"""The effects on moving arms, one file for each group of causes."""

from robolaser.motion.effect import MotionEffect
from robolaser.motion.effects.dynamics import DYNAMICS
from robolaser.motion.effects.friction import FRICTION
from robolaser.motion.effects.servo import TRACKING
from robolaser.motion.effects.transmission import TRANSMISSION

MOTION_EFFECTS: tuple[MotionEffect, ...] = (*TRACKING, *FRICTION, *DYNAMICS, *TRANSMISSION)
"""Everything that a diagnosis of a moving arm can name; in each kind of rows, clocks come first."""

__all__ = ["MOTION_EFFECTS"]
