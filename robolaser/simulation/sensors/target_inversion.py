"""Target points as their maker gives them, found from where effects take them."""

import numpy as np

from robolaser.arrays import Array
from robolaser.model.stages import Perturbation, Stage

EXACT_M = 1e-12
ROUNDS = 8  # effects may depend on the points that they perturb: repeat until nothing moves
INVERSION_STEPS = 60


def nominal_points(there: Array, perturb: Perturbation) -> Array:
    """The target points that effects move to where they really are, (m, 3) -> (m, 3) [m]; by fixed point."""
    nominal = there
    for _ in range(INVERSION_STEPS):
        missing = there - perturb(Stage.TARGET, nominal[None])[0]
        nominal = nominal + missing
        if not (np.abs(missing) > EXACT_M / 1000).any():
            break
    return nominal
