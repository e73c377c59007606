"""Gears between an encoder on the motor and one on the load."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from robolaser.arrays import Array
from robolaser.motion.effect import OF_ANGLE, OF_LOAD, MotionEffect, Number
from robolaser.motion.quantities import Quantities, at_joint, of_joint

TUTTLE = "Tuttle, Seering 1996, IEEE Trans. Robotics and Automation 12: a nonlinear model of a harmonic drive"
CYCLES = tuple(sorted({4, 50, 101, 202, *range(8, 65, 4), *range(70, 331, 10)}))
"""Cycles of a ripple per turn of the joint: among them the ratios of strain wave gears, 50 to 160, and twice these."""
SEEN_CYCLES = 2.0  # over the range of motion; fewer are indistinguishable from a smooth function
OF_DISC = (1, 2)  # cycles of a disc or rings that are not centred; a part of a turn shows them beside a ratio


def _wound(quantities: Quantities, joint: int) -> Sequence[Array]:
    """The load lags the motor by the torque of the motor, or of the arm."""
    return [at_joint(quantities, joint, -torque[:, joint]) for torque in (quantities.carried, quantities.rigid)]


def _lost(quantities: Quantities, joint: int) -> Sequence[Array]:
    """The load lags the motor: by its last direction of motion, or by the torque that it carries."""
    torque = quantities.carried[:, joint]
    steep = float(np.nanstd(torque)) or 1.0
    sides = quantities.approach[:, joint], np.tanh(10.0 * torque / steep)
    return [at_joint(quantities, joint, -side) for side in sides]


def _ripple(quantities: Quantities, joint: int) -> Sequence[Array]:
    q = quantities.q[:, joint]
    waves = [np.stack([np.cos(cycles * q), np.sin(cycles * q)], axis=-1) for cycles in _seen(quantities, joint)]
    return [at_joint(quantities, joint, wave) for wave in waves]


def _seen(quantities: Quantities, joint: int) -> Sequence[int]:
    """Cycles of a ripple that a joint's motion shows, those of a disc last."""
    turned = np.ptp(quantities.q[:, joint]) / (2.0 * np.pi)
    return [*(cycles for cycles in CYCLES if cycles * turned > SEEN_CYCLES), *OF_DISC]


def _turns(quantities: Quantities, joint: int) -> str:
    enough = max(CYCLES) * np.ptp(quantities.q[:, joint]) > SEEN_CYCLES * 2.0 * np.pi
    return "" if enough else "the joint moves through too few turns of its motor"


of_gear = partial(MotionEffect, cause="transmission", rows="load", reference=TUTTLE)
"""Defaults of an effect of a gear."""
TRANSMISSION = (
    of_gear(
        name="gear_spring", clause="the gear winds up under torque", numbers=(Number("compliance", "rad/Nm", 1e-5),),
        remedy="Give the simulated joint this stiffness.",
        columns=_wound, imitated_by=(OF_LOAD,),
    ),
    of_gear(
        name="lost_motion", clause="the gear has lost motion", numbers=(Number("angle", "rad", 3e-4),),
        remedy="Adjust or preload the gear.", reference="VDI/VDE 2608; lost motion of reduction gears, 0.3-1 mrad",
        columns=_lost, rivals=("clock_shift",), imitated_by=(OF_LOAD,),
    ),
    of_gear(
        name="gear_ripple", clause="the gear, or an encoder's disc, has a ripple",
        numbers=(Number("cosine", "rad", 1e-4), Number("sine", "rad", 1e-4)),
        remedy="Correct the reading by this wave, or replace the gear.", columns=_ripple, needs=_turns,
        rivals=("gear_ratio", "gear_spring"), imitated_by=(OF_ANGLE,),
        shape=lambda of, joint: ("cycles", "", _seen(of, joint)),
    ),
    of_gear(
        name="gear_ratio", clause="the gear ratio is not as stated", numbers=(Number("factor", "", 1e-3),),
        remedy="Correct the ratio in the controller.", reference="Data sheet of the gear",
        columns=of_joint(lambda of: of.q), imitated_by=(OF_ANGLE,),
    ),
)  # fmt: skip
