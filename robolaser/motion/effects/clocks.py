"""Torques, or a second encoder, that are not read at the instant of the first encoder."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from robolaser.arrays import Array
from robolaser.motion.effect import TIMING, MotionEffect, Number
from robolaser.motion.quantities import Quantities


def _late_encoder(quantities: Quantities, joint: int) -> Sequence[Array]:
    speed = quantities.speed * np.isfinite(quantities.measured)
    return [np.where(np.isfinite(speed), -speed, 0.0)[..., None]]


of_clock = partial(
    MotionEffect, name="clock_shift", cause="timing", site=TIMING,
    reference="Furgale, Rehder, Siegwart 2013, IROS: temporal calibration of sensors",
)  # fmt: skip
"""Defaults of a clock."""
CLOCKS = (
    of_clock(
        clause="torques are not read at the instant of the encoders, or are filtered", rows="torque",
        numbers=(Number("delay", "s", 0.005),), columns=lambda quantities, _: [-quantities.rigid_rate[..., None]],
        rivals=("viscous_friction", "rotor_inertia"),
        remedy="Read torques and encoders at one instant, or correct for the delay.",
    ),
    of_clock(
        clause="the two encoders are not read at the same instant", rows="load",
        numbers=(Number("delay", "s", 0.002),), columns=_late_encoder,
        remedy="Read both encoders at one instant, or correct for the delay.",
    ),
)  # fmt: skip
