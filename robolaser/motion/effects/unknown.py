"""Functions of unknown form: what a cause outside the library may do instead of an effect of smooth form."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from robolaser.arrays import Array
from robolaser.motion.effect import OF_ANGLE, OF_LOAD, UNKNOWN, MotionEffect, Number, RowKind
from robolaser.motion.quantities import LEAST_NM, Quantities, at_joint, hardly_moves
from robolaser.motion.servo import BENDS, DEGREE, over_range

NUMBERS = tuple(Number(f"factor_{degree}", "", 1.0) for degree in range(DEGREE + 1))


def _polynomials(values: Callable[[Quantities], Array]) -> Callable[[Quantities, int], Sequence[Array]]:
    """The columns of Chebyshev polynomials of a joint's values, of (n, j), over their range."""
    chebvander = np.polynomial.chebyshev.chebvander
    return lambda of, joint: [at_joint(of, joint, np.asarray(chebvander(over_range(values(of)[:, joint]), DEGREE)))]


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
        for name, columns, needs in (
            (OF_ANGLE, _polynomials(lambda of: of.q), hardly_moves),
            (OF_LOAD, _polynomials(lambda of: of.rigid), _is_loaded),
        )
    ),
)  # fmt: skip
"""Rivals only: no diagnosis names them."""
