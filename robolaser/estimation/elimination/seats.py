"""A ball and the sockets that it was seated in, from where the flange stood."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.estimation.elimination.newton import minimise


def seat(R: Array, t: Array, socket: Ints, lower: Array, upper: Array) -> tuple[Array, Array]:
    """The ball in the flange frame and the sockets that leave the least of Σ |socket - (R ball + t)|² within bounds.

    For a given ball each socket is the mean of its seats, or its bounds' nearest point to that: what remains is
    convex in the three numbers of the ball.

    Args:
        R: Of the flange at each seat, (c, m, 3, 3).
        t: Of the flange at each seat, (c, m, 3) [m].
        socket: Its number at each seat, (m,); each occurs.
        lower: Of the ball, then of each socket, (3 + 3 s,) [m].
        upper: The same.

    Returns:
        Ball (c, 3) and sockets (c, s, 3) [m].
    """
    c, s = len(R), int(socket.max()) + 1
    count = np.bincount(socket, minlength=s).astype(float)
    member = np.zeros((s, len(socket)))
    member[socket, np.arange(len(socket))] = 1.0 / count[socket]
    A = (member @ R.reshape(c, -1, 9)).reshape(c, s, 3, 3)
    middle = member @ t
    R_out, t_out = R - A[:, socket], t - middle[:, socket]
    stacked = R_out.reshape(c, -1, 3)
    W = np.swapaxes(stacked, 1, 2) @ stacked
    w = (np.swapaxes(stacked, 1, 2) @ t_out.reshape(c, -1, 1))[..., 0]
    left = (t_out**2).sum(axis=(1, 2))
    low, high = lower[3:].reshape(s, 3), upper[3:].reshape(s, 3)

    def objective(x: Array, which: Ints) -> tuple[Array, Array, Array]:
        mean = np.einsum("csij,cj->csi", A[which], x) + middle[which]
        beyond = mean - np.clip(mean, low, high)
        Wx = np.einsum("cij,cj->ci", W[which], x)
        J = left[which] + (x * (Wx + 2 * w[which])).sum(axis=1) + (count[:, None] * beyond**2).sum(axis=(1, 2))
        g = 2 * (Wx + w[which] + np.einsum("csij,csi,s->cj", A[which], beyond, count))
        stopped = np.where(beyond[..., None] != 0, A[which], 0.0)
        return J, g, 2 * (W[which] + np.einsum("csij,csik,s->cjk", stopped, stopped, count))

    ball = -(np.linalg.pinv(W, rcond=1e-12, hermitian=True) @ w[..., None])[..., 0]
    size = left + (middle**2).sum(axis=(1, 2))
    least, most = (np.broadcast_to(bound[:3], (c, 3)) for bound in (lower, upper))
    ball, _ = minimise(objective, ball, least, most, size)
    sockets = np.einsum("csij,cj->csi", A, ball) + middle
    return ball, np.clip(sockets, low, high)
