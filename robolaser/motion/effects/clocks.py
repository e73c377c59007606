"""Torques, or a second encoder, that are not read at the instant of the first encoder."""

from functools import partial

import numpy as np

from robolaser.motion.effect import TIMING, MotionEffect, Number

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
        numbers=(Number("delay", "s", 0.002),),
        columns=lambda of, _: [-np.nan_to_num(of.speed * np.isfinite(of.measured))[..., None]],
        remedy="Read both encoders at one instant, or correct for the delay.",
    ),
)  # fmt: skip
