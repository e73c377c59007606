"""From middles of the stripe to points of a cloud, one plane of light for each pose. Lee et al. 2004, 1-13."""

import numpy as np

from robolaser.arrays import Array
from robolaser.compiled.loops import compiled


@compiled
def vertices(
    middle: Array,
    row: Array,
    camera: Array,
    along_u: bool,
    sheet: Array,
    T_base_camera: Array,
    arm: Array,
    farthest: float,
    packed: bool,
    place: Array,
    pose: Array,
) -> int:
    """Where middles lie in the base frame.

    Args:
        middle: Stripes as (n, 5) float32: of each u, v, std [px] and intensity count, at 1 to 4.
        row: The same memory as uint32: the pose, at 0.
        camera: u_0, v_0 [px], s_u, s_v [m/px], k [1/m²], f [m], (6,).
        along_u: Whether the stripe runs along image u.
        sheet: n · P = d in the camera frame at each pose, (p, 4).
        T_base_camera: (p, 4, 4).
        arm: Scatter that the joints' noise makes at each pose, (p,) [m].
        farthest: From the camera along its view [m].
        packed: Whether to leave out what the sheet does not show in front of the camera; else it is NaN.
        place: Takes x, y, z, scatter [m] and, at 5, intensity, (n, 6) float32.
        pose: The same memory as uint32, takes the pose, at 4.

    Returns:
        How many were written.
    """
    u_0, v_0, s_u, s_v, k, f = camera
    count = 0
    for i in range(len(middle)):
        p = np.intp(row[i, 0])
        u, v = (np.float64(middle[i, 1]) - u_0) * s_u, (np.float64(middle[i, 2]) - v_0) * s_v
        r2 = u * u + v * v
        grown = 1.0 + k * r2
        if along_u:
            x, y, pitch = v, -u, s_v
        else:
            x, y, pitch = u, v, s_u
        # the pixel moves along x: so does the distorted image, and with it the undistorted one
        d_x, d_y = pitch * (grown + 2.0 * k * x * x), pitch * 2.0 * k * x * y
        x, y = x * grown, y * grown
        n_x, n_y, n_z, d = sheet[p, 0], sheet[p, 1], sheet[p, 2], sheet[p, 3]
        facing = 1.0 / (n_x * x + n_y * y + n_z * f)
        rho = d * facing
        z = rho * f
        seen = 0.0 < z < farthest
        if packed and not seen:
            continue
        turned = (n_x * d_x + n_y * d_y) * facing
        m_x, m_y, m_z = rho * (d_x - x * turned), rho * (d_y - y * turned), -z * turned
        sigma = np.float64(middle[i, 3])
        scatter = sigma * sigma * (m_x * m_x + m_y * m_y + m_z * m_z) + arm[p] * arm[p]
        x, y = rho * x, rho * y
        T = T_base_camera[p]
        for axis in range(3):
            at = T[axis, 0] * x + T[axis, 1] * y + T[axis, 2] * z + T[axis, 3]
            place[count, axis] = at if seen else np.nan
        place[count, 3] = np.sqrt(scatter)
        pose[count, 4] = row[i, 0]
        place[count, 5] = middle[i, 4]
        count += 1
    return count
