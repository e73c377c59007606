"""From line centres to points of a cloud, one laser plane for each pose. Lee et al. 2004, 1-13."""

import numpy as np

from robolaser.arrays import Array
from robolaser.compiled.decorators import compiled
from robolaser.model.effects.compiled_terms import RADIAL


@compiled
def vertices(
    centre: Array,
    row: Array,
    camera: Array,
    along_u: bool,
    plane: Array,
    T_base_camera: Array,
    arm: Array,
    lens: Array,
    light: Array,
    farthest: float,
    point: Array,
    pose: Array,
) -> int:
    """Line centres as points in the base frame.

    Args:
        centre: Stripes as (n, 5) float32: of each u, v, std [px] and intensity count, at 1 to 4.
        row: The same memory as uint32: the pose, at 0.
        camera: u_0, v_0 [px], s_u, s_v [m/px], k [1/m²], f [m], (6,).
        along_u: Whether the stripe runs along image u.
        plane: n · P = d in the camera frame at each pose, (p, 4).
        T_base_camera: (p, 4, 4).
        arm: Scatter that the joints' noise makes at each pose, (p,) [m].
        lens: What else distorts the image, one after the other, (s, 3): RADIAL with its k_2 [1/m⁴], or TANGENTIAL
            with its p_1 and p_2 [1/m].
        light: What curves the laser plane, one after the other, (l, 4): curvature [1/m], tangent of the cone, and the
            nominal plane's normal along x and z.
        farthest: From the camera along its view [m]; points elsewhere are left out.
        point: Takes x, y, z, scatter [m] and, at 5, intensity, (n, 6) float32.
        pose: The same memory as uint32, takes the pose, at 4.

    Returns:
        How many were written.
    """
    u_0, v_0, s_u, s_v, k, f = camera
    count = 0
    for i in range(len(centre)):
        p = np.intp(row[i, 0])
        u, v = (np.float64(centre[i, 1]) - u_0) * s_u, (np.float64(centre[i, 2]) - v_0) * s_v
        grown = 1.0 + k * (u * u + v * v)
        # the pixel moves along x: so does the distorted image, and with it the undistorted one
        across, along, pitch = (v, -u, s_v) if along_u else (u, v, s_u)
        d_x, d_y = pitch * (grown + 2.0 * k * across * across), pitch * 2.0 * k * across * along
        u, v = _undistorted(u * grown, v * grown, lens)
        x, y = (v, -u) if along_u else (u, v)
        n_x, n_y, n_z, d = plane[p, 0], plane[p, 1], plane[p, 2], plane[p, 3]
        facing = 1.0 / (n_x * x + n_y * y + n_z * f)
        rho = d * facing
        slide = _slide(rho * x, rho * y, rho * f, light)
        z = rho * f
        if not 0.0 < slide * z < farthest:
            continue
        turned = (n_x * d_x + n_y * d_y) * facing
        m_x, m_y, m_z = rho * (d_x - x * turned), rho * (d_y - y * turned), -z * turned
        sigma = np.float64(centre[i, 3])
        scatter = sigma * sigma * (m_x * m_x + m_y * m_y + m_z * m_z) + arm[p] * arm[p]
        x, y, z = slide * rho * x, slide * rho * y, slide * z
        T = T_base_camera[p]
        for axis in range(3):
            point[count, axis] = T[axis, 0] * x + T[axis, 1] * y + T[axis, 2] * z + T[axis, 3]
        point[count, 3] = np.sqrt(scatter)
        pose[count, 4] = row[i, 0]
        point[count, 5] = centre[i, 4]
        count += 1
    return count


@compiled
def _undistorted(u: float, v: float, lens: Array) -> tuple[float, float]:
    """Image points with the lens terms' distortion taken off [m]."""
    for s in range(len(lens)):
        r2 = u * u + v * v
        if lens[s, 0] == RADIAL:
            grown = 1.0 + lens[s, 1] * r2 * r2
            u, v = u * grown, v * grown
        else:
            p_1, p_2, uv = lens[s, 1], lens[s, 2], 2.0 * u * v
            u, v = u + p_1 * uv + p_2 * (r2 + 2.0 * u * u), v + p_1 * (r2 + 2.0 * v * v) + p_2 * uv
    return u, v


@compiled
def _slide(x: float, y: float, z: float, light: Array) -> float:
    """How many times as far a ray meets a curved laser plane as the flat one."""
    far = 1.0
    for s in range(len(light)):
        curvature, cone, n_x, n_z = light[s]
        away, ahead, beside = far * (n_x * x + n_z * z), abs(far * z / n_x), far * y
        less = 1.0 - cone * (np.sqrt(ahead * ahead + beside * beside) - ahead) / away
        bulge = curvature * beside * beside / (2.0 * away)
        far *= 2.0 / (less + np.sqrt(max(less * less - 4.0 * bulge, 0.0)))
    return far


def warm_up() -> None:
    """Compile `vertices`."""
    stripes, out = np.zeros((1, 5), np.float32), np.zeros((1, 6), np.float32)
    camera, frame, nothing_else = np.ones(6), np.zeros((1, 4, 4)), (np.zeros((1, 3)), np.zeros((1, 4)))
    arm, plane = np.zeros(1), np.ones((1, 4))
    taken = stripes.view(np.uint32), camera, True, plane, frame, arm, *nothing_else, 1.0, out, out.view(np.uint32)
    vertices(stripes, *taken)
