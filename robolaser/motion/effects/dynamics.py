"""Masses, inertias and torque constants that differ from the URDF and the data sheet."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from robolaser.arrays import Array
from robolaser.motion.effect import JOINTS, OF_ANGLE, OF_LOAD, TOOL, MotionEffect, Number
from robolaser.motion.quantities import LEAST_NM, Quantities, hardly_moves, of_joint

GAUTIER = "Gautier, Khalil 1990, IEEE Trans. Robotics and Automation 6: base inertial parameters"
MASS = ("mass", "kg"), ("mass_x", "kg m"), ("mass_y", "kg m"), ("mass_z", "kg m")


def _payload(quantities: Quantities, joint: int) -> Sequence[Array]:
    columns = quantities.payload()
    starts = range(min(len(quantities.log.series), MOST_STARTS))
    return [columns * (quantities.run >= run)[:, None, None] for run in starts]


def _sizes(quantities: Quantities, joint: int) -> Array:
    """Prior sizes of a mass, its three first moments and, for a link, its six moments of inertia."""
    mass, reach = quantities.masses[joint], quantities.reach * OF_REACH
    return np.asarray(np.maximum(mass * np.repeat([1.0, reach, reach**2], [1, 3, 6]), SMALLEST))


def _least_of_payload(quantities: Quantities, joint: int) -> Array:
    """Lower bounds at which the total mass on the last joint is zero."""
    arm = quantities.log.robot.by_pinocchio
    return np.array([-arm.inertial_numbers(arm.tip)[0], -np.inf, -np.inf, -np.inf])


def _least_of_link(quantities: Quantities, joint: int) -> Array:
    """Lower bounds at which mass and moments of inertia are zero; the other moments have either sign."""
    return np.where(NEVER_NEGATIVE, -quantities.inertial_numbers(joint), -np.inf)


NEVER_NEGATIVE = np.array([True, False, False, False, True, False, True, False, False, True])
"""Mask of the numbers of a link: mass, xx, yy and zz."""
SMALLEST = 1e-3
OF_REACH = 1.0 / 3.0  # the length of a link
MOST_STARTS = 40  # runs at whose start a payload may have been picked up


def _weighs(quantities: Quantities, joint: int) -> str:
    return "" if np.nanstd(quantities.rigid[:, joint]) > LEAST_NM else "the URDF's masses put no torque on this joint"


of_mass = partial(MotionEffect, cause="dynamics", rows="torque", reference=GAUTIER)
"""Defaults of an effect of masses or of the scale of torques."""
TORQUE_CONSTANT = of_mass(
    name="torque_constant", clause="the measured torques have a wrong scale",
    numbers=(Number("factor", "", 0.1, -0.9, 9.0),),
    remedy="Check the motor's torque constant and the gear's ratio.",
    reference="Gautier, Briot 2014, J. Dyn. Sys. 136: drive gains",
    columns=of_joint(lambda of: of.rigid), needs=_weighs, rivals=("payload", "link_inertia"),
    imitated_by=(OF_ANGLE, OF_LOAD),
)  # fmt: skip
DYNAMICS = (
    of_mass(
        name="payload", clause="the payload differs from the model's", site=TOOL,
        numbers=tuple(Number(name, unit, 0.5) for name, unit in MASS),
        remedy="Weigh the tool, and give the model its mass and centre.", columns=_payload,
        sizes=lambda quantities, _: _sizes(quantities, 0)[:4],
        least=_least_of_payload,
        rivals=("link_inertia",),
    ),
    of_mass(
        name="rotor_inertia", clause="the motor's inertia is missing", numbers=(Number("inertia", "kg m²", 0.5, 0.0),),
        remedy="Give the simulated joint this armature.", reference="Siciliano et al. 2009, Robotics, ch. 7.3.4",
        columns=of_joint(lambda of: of.acceleration), needs=hardly_moves, rivals=("link_inertia",),
    ),
    TORQUE_CONSTANT,
    replace(
        TORQUE_CONSTANT, form="one for all", site=JOINTS, clause="all measured torques have one wrong scale",
        remedy="Check the unit of the torques; links that are all heavier or lighter by this share look the same.",
        columns=lambda quantities, _: [quantities.rigid[:, :, None]], needs=None, imitated_by=(),
    ),
    of_mass(
        name="link_inertia", clause="the link's mass or inertia differs from the URDF's",
        numbers=tuple(Number(name, unit, 0.5) for name, unit in (
            *MASS, ("xx", "kg m²"), ("xy", "kg m²"), ("yy", "kg m²"), ("xz", "kg m²"), ("yz", "kg m²"), ("zz", "kg m²"),
        )),
        remedy="Apply the determined changes to the URDF's link: its mass and inertia must stay positive.",
        columns=lambda quantities, joint: [quantities.regressor(joint)], sizes=_sizes, least=_least_of_link, rarity=4.0,
        rivals=("payload", "rotor_inertia", "torque_constant", "link_inertia"),  # a mass on an axis is either link's
        imitated_by=(OF_ANGLE, OF_LOAD),
    ),
)  # fmt: skip
