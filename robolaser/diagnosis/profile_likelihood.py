"""The likelihood of residuals, profiled over an unknown scatter of whole poses.

With ν residuals that only scatter moves, a gain g of chi-squared counts as ν log(1 + g/ν): few poses give no certainty.
Cox, Reid 1987, J. R. Stat. Soc. B 49.
"""

from typing import Final

import numpy as np

from robolaser.arrays import Array

SIZES: Final = np.geomspace(1e-2, 1e4, 61)
"""Unknown sizes that are tried: of a function, relative to one that is just visible in the noise; of effects, relative
to those usual in industry; of a scatter, relative to the assumed one. Wide enough that the likeliest is inside."""


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

    unscattered = squares * (1.0 + variances)

    def change(factors: Array) -> Array:
        grown = 1.0 + factors[:, None] ** 2 * variances
        fall = squares.sum() - (1.0 / grown) @ unscattered
        return np.asarray(share * (np.log(grown).sum(axis=1) - np.log1p(variances).sum()) - fall)

    best = SIZES[np.argmin(change(SIZES))]
    near = best * (SIZES[1] / SIZES[0]) ** np.linspace(-1.0, 1.0, len(SIZES))
    changes = change(near)
    least = int(np.argmin(changes))
    return float(near[least]), min(0.0, float(changes[least]))
