"""Functions of unknown form: what a cause outside the library may do instead of an effect of smooth form."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from robolaser.arrays import Array
from robolaser.motion.effect import OF_ANGLE, OF_LOAD, UNKNOWN, MotionEffect, Number, RowKind
from robolaser.motion.quantities import LEAST_NM, Quantities, at_joint, hardly_moves
from robolaser.motion.servo import BENDS, DEGREE, over_range

NUMBERS = tuple(Number(f"factor_{degree}", "", 1.0) for degree in range(DEGREE + 1))


def polynomials(values: Array) -> Array:
    """Chebyshev polynomials of values (n,) over their range, (n, degrees)."""
    return np.asarray(np.polynomial.chebyshev.chebvander(over_range(values), DEGREE), np.float64)


def _of_angle(of: Quantities, joint: int) -> Sequence[Array]:
    return [at_joint(of, joint, polynomials(of.q[:, joint]))]


def _of_load(of: Quantities, joint: int) -> Sequence[Array]:
    return [at_joint(of, joint, polynomials(of.rigid[:, joint]))]


def _is_loaded(of: Quantities, joint: int) -> str:
    return "" if np.ptp(of.rigid[:, joint]) > LEAST_NM else "the load on the joint hardly changes"


RARITY = 12.0  # of a cause outside the library, as in the diagnosis of poses
BESIDE_LINKS = 28.0  # four numbers of some thousand rows: of a link's ten, some hardly show
of_unknown = partial(MotionEffect, cause=UNKNOWN, clause="", numbers=NUMBERS, remedy="", reference="")
"""Defaults of a function."""
_LINEAR: tuple[tuple[RowKind, float], ...] = (("torque", RARITY + BESIDE_LINKS), ("load", RARITY))
FUNCTIONS = (
    of_unknown(
        name=OF_ANGLE, rows="tracking", rarity=RARITY,
        numbers=tuple(Number(name, "rad", 0.005, servo=name) for name in BENDS),
    ),
    *(
        of_unknown(name=name, rows=rows, rarity=rarity, columns=columns, needs=needs)
        for rows, rarity in _LINEAR
        for name, columns, needs in ((OF_ANGLE, _of_angle, hardly_moves), (OF_LOAD, _of_load, _is_loaded))
    ),
)  # fmt: skip
"""Rivals only: no diagnosis names them."""
