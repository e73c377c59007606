"""How many times errors are enlarged so that one sees them."""

import numpy as np

LONG = 0.08  # of what is shown: a long arrow


def magnification(error: float, extent: float) -> float:
    """The factor, 1, 2 or 5 times a power of ten, that shows an error as a long arrow."""
    if error <= 0 or extent <= 0:
        return 1.0
    wanted = np.log10(LONG * extent / error)
    power = np.floor(wanted)
    step = max((one for one in (1.0, 2.0, 5.0) if np.log10(one) <= wanted - power + 1e-9), default=1.0)
    return float(step * 10.0**power)
