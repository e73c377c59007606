"""J of eq. 18 for a population of stripe scanners in one loop, from pixels to squared distances. Lee et al. 2004."""

import numpy as np

from robolaser.arrays import Array
from robolaser.compiled.decorators import compiled


@compiled
def costs(
    first: int, last: int, lens: Array, plane: Array, T_flange_camera: Array, image: Array, known: Array, J: Array
) -> None:
    """J of eq. 18 for an arm that stands the same for all candidates.

    Args:
        first: First candidate.
        last: The one after the last.
        lens: Origins of the camera's x and y in the image [px], their pitches [m/px], k [1/m²] and f [m], (c, 6).
        plane: The laser plane as n · P = d in the camera frame, (c, 4).
        T_flange_camera: (c, 4, 4).
        image: Pixels along the camera's x and y, (2, m) [px].
        known: Target points in the flange frame, (3, m) [m].
        J: Takes the sums, (c,) [m²]; infinite at the model's poles.
    """
    start, stop = np.uintp(0), np.uintp(image.shape[1])  # signed, an index might count from the end: no vector code
    for i in range(first, last):
        x_0, y_0, s_x, s_y, k, f = lens[i]
        n_x, n_y, n_z, d = plane[i]
        r_xx, r_xy, r_xz, t_x = T_flange_camera[i, 0]
        r_yx, r_yy, r_yz, t_y = T_flange_camera[i, 1]
        r_zx, r_zy, r_zz, t_z = T_flange_camera[i, 2]
        n_f, r_xf, r_yf, r_zf = n_z * f, r_xz * f, r_yz * f, r_zz * f
        total = 0.0
        for r in range(start, stop):
            x, y = (image[0, r] - x_0) * s_x, (image[1, r] - y_0) * s_y
            grown = 1.0 + k * (x * x + y * y)
            x, y = x * grown, y * grown
            rho = d / (n_x * x + n_y * y + n_f)
            e_x = known[0, r] - t_x - rho * (r_xx * x + r_xy * y + r_xf)
            e_y = known[1, r] - t_y - rho * (r_yx * x + r_yy * y + r_yf)
            e_z = known[2, r] - t_z - rho * (r_zx * x + r_zy * y + r_zf)
            total += e_x * e_x + e_y * e_y + e_z * e_z
        J[i] = total if np.isfinite(total) else np.inf


def warm_up() -> None:
    """Compile all that is called from outside."""
    costs(0, 1, np.ones((1, 6)), np.ones((1, 4)), np.ones((1, 4, 4)), np.ones((2, 1)), np.ones((3, 1)), np.empty(1))
