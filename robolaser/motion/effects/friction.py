"""Friction in joints, seen in their torques."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from robolaser.arrays import Array
from robolaser.motion.effect import OF_ANGLE, OF_LOAD, MotionEffect, Number
from robolaser.motion.quantities import LEAST_NM, Quantities, at_joint, hardly_moves, of_joint

ARMSTRONG = "Armstrong-Hélouvry, Dupont, Canudas de Wit 1994, Automatica 30"
STRIBECK_SPEEDS = (0.03, 0.1, 0.3)
"""Speeds at which the Stribeck effect has fallen to 1/e, as shares of a joint's largest speed."""
REMEDY = "Give the simulated joint this friction: MuJoCo's damping and frictionloss."


def _stribeck(quantities: Quantities, joint: int) -> Sequence[Array]:
    speed, direction = quantities.speed[:, joint], quantities.direction[:, joint]
    falls = [np.exp(-((speed / fallen) ** 2)) for fallen in _fallen_at(quantities, joint)]
    return [at_joint(quantities, joint, direction * fall) for fall in falls]


def _fallen_at(quantities: Quantities, joint: int) -> Sequence[float]:
    most = float(np.abs(quantities.speed[:, joint]).max(initial=1e-9))
    return [share * most for share in STRIBECK_SPEEDS]


def _shared(quantities: Quantities, joint: int) -> Sequence[Array]:
    others = [other for other in (joint - 1, joint + 1) if 0 <= other < quantities.speed.shape[1]]
    return [at_joint(quantities, joint, quantities.direction[:, other]) for other in others]


def _loaded(quantities: Quantities, joint: int) -> str:
    changes = np.nanstd(np.abs(quantities.rigid[:, joint])) > LEAST_NM
    return hardly_moves(quantities, joint) or ("" if changes else "the load on the joint hardly changes")


of_friction = partial(
    MotionEffect, cause="friction", rows="torque", remedy=REMEDY, reference=ARMSTRONG, needs=hardly_moves
)
"""Defaults of friction in a joint."""
FRICTION = (
    of_friction(
        name="viscous_friction", clause="friction grows with speed", numbers=(Number("factor", "Nm s/rad", 1.0, 0.0),),
        columns=of_joint(lambda of: of.speed), rivals=("coulomb_friction",),
    ),
    of_friction(
        name="coulomb_friction", clause="the joint has dry friction", numbers=(Number("torque", "Nm", 1.0, 0.0),),
        columns=of_joint(lambda of: of.direction), rivals=("viscous_friction", "load_friction"),
    ),
    of_friction(
        name="asymmetric_friction",
        clause="friction differs between the directions of motion, or the torques have an offset",
        numbers=(Number("torque", "Nm", 0.5),), reference="Bona, Indri 2005, CDC: friction compensation in robotics",
        remedy="Record torques with the brakes on: what is read there is an offset, to be subtracted.",
        columns=of_joint(lambda of: np.abs(of.direction)), rivals=("link_inertia",), imitated_by=(OF_ANGLE, OF_LOAD),
    ),
    of_friction(
        name="stribeck_friction", clause="friction is larger at low speed", numbers=(Number("torque", "Nm", 0.5, 0.0),),
        columns=_stribeck, shape=lambda of, joint: ("speed", "rad/s", _fallen_at(of, joint)),
        rivals=("coulomb_friction", "viscous_friction"),
    ),
    of_friction(
        name="load_friction", clause="friction grows with the load", numbers=(Number("share", "", 0.05, 0.0, 1.0),),
        reference="Bittencourt, Gunnarsson 2012, J. Dyn. Sys. 134: static friction in a robot joint",
        columns=of_joint(lambda of: of.direction * np.abs(of.rigid)), needs=_loaded, rivals=("coulomb_friction",),
    ),
    of_friction(
        name="coupled_friction", clause="friction follows the motion of a neighbouring joint",
        numbers=(Number("torque", "Nm", 0.5),), remedy="Move the neighbouring joint alone to see it.",
        reference="Khalil, Dombre 2002, Modeling, identification and control of robots: coupled wrists",
        columns=_shared,
    ),
)  # fmt: skip
