"""The likelihood of residuals, profiled over an unknown scatter of whole poses.

With ν residuals that only scatter moves, a gain g of chi-squared counts as ν log(1 + g/ν): few poses give no certainty.
Cox, Reid 1987, J. R. Stat. Soc. B 49.
"""

import numpy as np

from robolaser.arrays import Array

FACTORS = np.concatenate([[0.0], np.geomspace(0.02, 1e5, 200)])  # first grid of the ratio of scatter to the assumed one
ZOOM = np.linspace(-1.0, 1.0, 41)
AT_ONCE = 8  # number of variances per logarithm: their product stays within double precision


def profile(squares: Array, variances: Array, share: float) -> tuple[float, float]:
    """The ratio of the likeliest scatter to the assumed one, and the change of minus twice the log-likelihood.

    Args:
        squares: Squared residuals, whitened with the assumed scatter, (n,).
        variances: Variances by the assumed scatter, in units of the other noise, (n,).
        share: Share of the residuals that remains beside fitted parameters.

    Returns:
        Ratio and change, which is at most zero.
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
