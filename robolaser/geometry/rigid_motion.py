"""Rigid motions, batched: every function takes any leading axes. `T_a_c = T_a_b @ T_b_c`."""

import numpy as np

from robolaser.arrays import Array, Ints

Quaternion = tuple[float, float, float, float]  # x, y, z, w
_X, _Y, _Z = 0, 1, 2


def _turn(angle: Array, axis: int) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    R = np.zeros_like(c, shape=(*np.shape(angle), 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[..., axis, axis] = 1.0
    R[..., i, i], R[..., i, j] = c, -s
    R[..., j, i], R[..., j, j] = s, c
    return R


def rot_x(angle: Array) -> Array:
    """Turns about x by angles (...) [rad] -> (..., 3, 3)."""
    return _turn(angle, _X)


def rot_y(angle: Array) -> Array:
    """Turns about y by angles (...) [rad] -> (..., 3, 3)."""
    return _turn(angle, _Y)


def rot_z(angle: Array) -> Array:
    """Turns about z by angles (...) [rad] -> (..., 3, 3)."""
    return _turn(angle, _Z)


def skew(vector: Array) -> Array:
    """Cross-product matrices: `skew(a) @ b = a × b`, (..., 3) -> (..., 3, 3)."""
    K = np.zeros_like(vector, shape=(*vector.shape, 3), dtype=float)
    K[..., 0, 1], K[..., 0, 2], K[..., 1, 2] = -vector[..., 2], vector[..., 1], -vector[..., 0]
    K[..., 1, 0], K[..., 2, 0], K[..., 2, 1] = vector[..., 2], -vector[..., 1], vector[..., 0]
    return K


def exp_so3(turn: Array) -> Array:
    """Rotation by a turn vector (axis times angle), (..., 3) [rad] -> (..., 3, 3). Rodrigues' formula."""
    angle = np.linalg.norm(turn, axis=-1)[..., None, None]
    outer, half = turn[..., None] * turn[..., None, :], np.sinc(angle / (2 * np.pi))
    R: Array = np.cos(angle) * np.eye(3) + np.sinc(angle / np.pi) * skew(turn) + 0.5 * half**2 * outer
    return R


def rotation_to_axis(axis: Array) -> Array:
    """Some rotation whose third column is a unit vector (3,); exact for the axes of coordinates."""
    if axis[2] == 1.0:
        return np.eye(3)
    x = np.cross(np.eye(3)[np.argmin(np.abs(axis))], axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def log_so3(R: Array) -> Array:
    """Turn vectors (axis times angle, at most π) of rotations (..., 3, 3) -> (..., 3) [rad]; inverse of `exp_so3`."""
    q = _along_quaternion(R)
    sine, cosine = np.linalg.norm(q[..., :3], axis=-1), q[..., 3]
    angle = 2.0 * np.arctan2(sine, cosine)
    return q[..., :3] * (np.where(sine > 0.0, angle, 2.0) / np.where(sine > 0.0, sine, cosine))[..., None]


def pose(R: Array, t: Array) -> Array:
    """Combine rotations (..., 3, 3) and translations (..., 3) [m], -> (..., 4, 4)."""
    lead = np.broadcast_shapes(R.shape[:-2], t.shape[:-1])
    T = np.zeros_like(R if isinstance(t, np.ndarray) else t, shape=(*lead, 4, 4), dtype=float)
    T[..., :3, :3] = R
    T[..., :3, 3] = t
    T[..., 3, 3] = 1.0
    return T


def inverse(T: Array) -> Array:
    """T_b_a from T_a_b, (..., 4, 4)."""
    R_inv = np.swapaxes(T[..., :3, :3], -1, -2)
    return pose(R_inv, -np.einsum("...ij,...j->...i", R_inv, T[..., :3, 3]))


def own_twists(T: Array, slopes: Array) -> Array:
    """Twists of motions T in their own frames, shifts before turns, (..., 6), from the slopes of T (..., 4, 4)."""
    W = inverse(T) @ slopes
    return np.stack([W[..., 0, 3], W[..., 1, 3], W[..., 2, 3], W[..., 2, 1], W[..., 0, 2], W[..., 1, 0]], axis=-1)


def apply(T: Array, points: Array) -> Array:
    """Carry points (..., 3) from frame b to frame a by T_a_b (..., 4, 4); leading axes broadcast."""
    moved: Array = T[..., :3, 3] + T[..., :3, 0] * points[..., :1]
    moved += T[..., :3, 1] * points[..., 1:2]
    moved += T[..., :3, 2] * points[..., 2:]
    return moved


def carry(T: Array, of_row: Ints, points: Array) -> Array:
    """Carry each point by the motion of its row.

    Args:
        T: T_a_b, (c or 1, n or 1, 4, 4); a single one is for all rows.
        of_row: Index of each row's motion, (m,).
        points: In frame b, (c or 1, m or 1, 3) [m].

    Returns:
        In frame a, (c, m, 3) [m].
    """
    rows = of_row if T.shape[1] > 1 else np.zeros_like(of_row)
    T = T[:, :, :3].swapaxes(1, 2).swapaxes(2, 3)  # (c, 3, 4, n): each entry is contiguous over n
    x, y, z = points[..., 0], points[..., 1], points[..., 2]
    moved = []
    for axis in range(3):
        along = T[:, axis, 0].take(rows, axis=1) * x
        along += T[:, axis, 1].take(rows, axis=1) * y
        along += T[:, axis, 2].take(rows, axis=1) * z
        along += T[:, axis, 3].take(rows, axis=1)
        moved.append(along)
    return np.stack(moved, axis=-1)


def from_angles(w: Array, phi: Array, psi: Array, *, order: str = "xyz") -> Array:
    """R_x(w) R_y(φ) R_z(ψ), or with `order` "zyz" R_z(w) R_y(φ) R_z(ψ) (eq. 10); (...) [rad] -> (..., 3, 3)."""
    first = rot_x(w) if order == "xyz" else rot_z(w)
    return first @ rot_y(phi) @ rot_z(psi)


def to_angles(R: Array, *, order: str = "xyz") -> tuple[Array, Array, Array]:
    """(w, φ, ψ) of which `from_angles` makes R, (..., 3, 3) -> three of (...) [rad]; φ within ±π/2, for "zyz" 0 to π.

    Where φ determines only the sum or difference of the others, w is zero.
    """
    if order == "xyz":
        cos = np.hypot(R[..., 0, 0], R[..., 0, 1])
        phi = np.arctan2(R[..., 0, 2], cos)
        w = np.where(cos > 0, np.arctan2(-R[..., 1, 2], R[..., 2, 2]), 0.0)
        across = np.cos(w)[..., None] * R[..., 1, :] + np.sin(w)[..., None] * R[..., 2, :]
    else:
        sin = np.hypot(R[..., 0, 2], R[..., 1, 2])
        phi = np.arctan2(sin, R[..., 2, 2])
        w = np.where(sin > 0, np.arctan2(R[..., 1, 2], R[..., 0, 2]), 0.0)
        across = np.cos(w)[..., None] * R[..., 1, :] - np.sin(w)[..., None] * R[..., 0, :]
    # with w known the rest follows without loss, also where the middle angle is 90°
    return w, phi, np.arctan2(across[..., 0], across[..., 1])


def from_quaternion(xyzw: Array) -> Array:
    """Rotations of quaternions (x, y, z, w), (..., 4) -> (..., 3, 3); they are normalised first."""
    q = xyzw / np.linalg.norm(xyzw, axis=-1, keepdims=True)
    K = skew(q[..., :3])
    R: Array = np.eye(3) + 2 * q[..., 3, None, None] * K + 2 * (K @ K)
    return R


def to_quaternion(R: Array) -> Array:
    """Quaternions (x, y, z, w), w >= 0, of rotations (..., 3, 3) -> (..., 4)."""
    q = _along_quaternion(R)
    unit: Array = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return unit


def _along_quaternion(R: Array) -> Array:
    """Vectors along the quaternions of rotations, w >= 0, (..., 3, 3) -> (..., 4): without loss at any angle.

    They are the rows of 4 q qᵀ with the largest diagonal entries (Shepperd 1978).
    """
    x, y, z = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    Q = np.zeros_like(R, shape=(*R.shape[:-2], 4, 4), dtype=float)
    for i, diagonal in enumerate((x - y - z, y - x - z, z - x - y, x + y + z)):
        Q[..., i, i] = 1.0 + diagonal
    for i, j in ((0, 1), (1, 2), (2, 0)):
        k = 3 - i - j
        Q[..., i, j] = Q[..., j, i] = R[..., i, j] + R[..., j, i]
        Q[..., k, 3] = Q[..., 3, k] = R[..., j, i] - R[..., i, j]
    largest = np.argmax(np.einsum("...ii->...i", Q), axis=-1)
    q = np.take_along_axis(Q, largest[..., None, None], axis=-2)[..., 0, :]
    return q * np.where(q[..., 3:] < 0.0, -1.0, 1.0)


def nearest_rotation(M: Array) -> tuple[Array, Array]:
    """The rotation R (..., 3, 3) with the largest tr(Rᵀ M), and M's singular values, (..., 3).

    The last of these is negative where the nearest orthogonal matrix is a reflection. Umeyama 1991.
    """
    U, s, Vt = np.linalg.svd(M)
    sign = np.where(np.linalg.det(U) * np.linalg.det(Vt) < 0, -1.0, 1.0)
    U[..., :, 2] *= sign[..., None]
    s[..., 2] *= sign
    return U @ Vt, s


def rigid_fit(source: Array, image: Array) -> Array:
    """T_a_b (..., 4, 4) that brings points in frame b nearest to their images in frame a, (..., m, 3) [m] each.

    In least squares. Source: Umeyama 1991, with the scale held at one.
    """
    share = 1.0 / source.shape[-2]
    mean_b, mean_a = (share * source).sum(axis=-2), (share * image).sum(axis=-2)
    H = np.swapaxes(share * (source - mean_b[..., None, :]), -1, -2) @ (image - mean_a[..., None, :])
    R, _ = nearest_rotation(np.swapaxes(H, -1, -2))
    return pose(R, mean_a - np.einsum("...ij,...j->...i", R, mean_b))
