"""The likelihood of residuals where the scatter of whole poses is unknown: profiled over that scatter.

With ν residuals that scatter alone moves, a gain g of chi-squared counts as ν log(1 + g/ν): few poses give no
certainty. Cox, Reid 1987, J. R. Stat. Soc. B 49.
"""

import numpy as np

from robolaser.arrays import Array

FACTORS = np.concatenate([[0.0], np.geomspace(0.02, 1e5, 200)])
"""Scatter over the assumed one, where its likelihood is first looked at."""
ZOOM = np.linspace(-1.0, 1.0, 41)
AT_ONCE = 8
"""Variances of which one logarithm is taken: that of their product, which stays within double precision."""


def profile(squares: Array, variances: Array, share: float) -> tuple[float, float]:
    """The likeliest scatter over the assumed one, and by how much minus twice the log-likelihood falls with it.

    Args:
        squares: Of residuals that are white with the assumed scatter, (n,).
        variances: By the assumed scatter, in units of the rest of the noise, (n,).
        share: Of the residuals, what fitted parameters leave.

    Returns:
        Factor and change, which is not above zero.
    """
    if not len(squares):
        return 1.0, 0.0

    padded = np.pad(variances, (0, -len(variances) % AT_ONCE))
    unscattered = squares * (1.0 + variances)

    def change(factors: Array) -> Array:
        grown = 1.0 + factors[:, None] ** 2 * padded
        logarithms = np.log(grown.reshape(len(factors), AT_ONCE, -1).prod(axis=1)).sum(axis=1)
        fall = squares.sum() - (1.0 / grown[:, : len(squares)]) @ unscattered
        return np.asarray(share * (logarithms - np.log1p(variances).sum()) - fall)

    best = int(np.argmin(change(FACTORS)))
    if best == 0:
        return 0.0, float(change(FACTORS[:1])[0])
    near = FACTORS[best] * (FACTORS[-1] / FACTORS[-2]) ** ZOOM
    changes = change(near)
    least = int(np.argmin(changes))
    return float(near[least]), min(0.0, float(changes[least]))
