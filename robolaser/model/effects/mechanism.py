"""Parts of a machine that represent effects in a simulator."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array


@final
@dataclass(frozen=True)
class Play:
    """A joint that lags within a play of this width [rad or m], held by friction."""

    joint: str
    width: float
    friction: float  # [Nm or N]: more than the link's weight, else it would always be on the same side


@final
@dataclass(frozen=True)
class ElasticJoint:
    """A joint with a spring behind its encoder."""

    joint: str  # its name
    sunk: Array  # its deflection in each pose, (n,) [rad or m]
    borne: Array  # its load there by the stated masses, (n,) [Nm or N]
    of_one_kg: Array  # and by each further kilogram at the flange, (n,)


@final
@dataclass(frozen=True)
class MimicJoint:
    """A joint that moves by ratio times another joint's reading, or its own, plus an offset [rad or m]."""

    joint: str
    other: str
    ratio: float
    offset: float = 0.0


@final
@dataclass(frozen=True)
class Footing:
    """The robot's support, turning on springs."""

    axes: Array  # unit vectors in the base frame, (a, 3)
    stiffness: Array  # about each, (a,) [Nm/rad]
    at: Array  # where the axes cross, in the base frame, (3,) [m]


MechanismPart = Play | ElasticJoint | MimicJoint | Footing
