"""Motion of the flange with the joints and with their placements: the geometric Jacobian of a serial arm.

Siciliano, Khatib 2016, Springer Handbook of Robotics, ch. 2.8.
"""

from dataclasses import dataclass
from typing import Any, cast, final

import numpy as np

from robolaser.arrays import Array
from robolaser.duals import is_dual, joined
from robolaser.geometry.rigid_motion import own_twists, skew


@final
@dataclass(frozen=True, eq=False)
class FlangeMotion:
    """The flange at each pose, and its twists: the shift of the point at the base's origin, and the turn.

    Twists are in the base frame [m, rad].
    """

    T_base_flange: Array  # (c, n, 4, 4)
    by_joints: Array  # per unit of each joint, (c, n, 6, j)
    by_placements: Array | None  # per unit of each joint's shift and turn in its own frame, (c, n, 6, j, 6)

    def carried(self, q: Array, placements: Array) -> Array:
        """T_base_flange with the derivatives of joint values or placements."""
        angles, placed, twists = cast("Any", q), cast("Any", placements), []
        if is_dual(q):
            twists.append((angles.of, self.twists_by_joints(angles.slopes.swapaxes(0, 1))))
        if is_dual(placements):
            by_links = self.twists_by_placements(placed.value, placed.slopes.swapaxes(0, 1))
            twists.append((placed.of, by_links))
        T = self.T_base_flange
        moved: Any = joined(T, [(of, moved_by_twists(T, each).swapaxes(0, 1)) for of, each in twists])
        return cast("Array", moved)

    def jacobian(self, points: Array | None = None) -> Array:
        """Velocity and angular velocity of points that the flange carries, (c or 1, n, 3), or of its origin.

        Returns:
            Per unit speed of each joint, (c, n, 6, j).
        """
        points = self.T_base_flange[..., :3, 3] if points is None else points
        shift, turn = self.by_joints[..., :3, :], self.by_joints[..., 3:, :]
        return np.concatenate([shift - skew(points) @ turn, turn], axis=-2)

    def twists_by_joints(self, moves: Array) -> Array:
        """Twists by small motions of the joints in q directions, (c or 1, q, n or 1, j) [rad or m] -> (c, q, n, 6)."""
        return np.moveaxis(self.by_joints @ np.moveaxis(moves, 1, -1), -1, 1)

    def twists_by_placements(self, placements: Array, moves: Array) -> Array:
        """Twists by changes of placements of the joints (c or 1, n or 1, j, 4, 4) in q directions, (c, q, n, 6).

        The moves are small, (c or 1, q, n or 1, j, 4, 4).
        """
        assert self.by_placements is not None  # requested by the caller
        c, n = self.by_placements.shape[:2]
        out = np.zeros((max(c, len(moves)), moves.shape[1], n, 6))
        for i in range(moves.shape[3]):
            which = moves[:, :, :, i].any(axis=(0, 2, 3, 4))
            if which.any():
                own = own_twists(placements[:, None, :, i], moves[:, :, :, i][:, which])
                out[:, which] += np.moveaxis(self.by_placements[:, :, :, i] @ np.moveaxis(own, 1, -1), -1, 1)
        return out


def moved_by_twists(T: Array, twists: Array) -> Array:
    """First-order changes of motions T (c, n, 4, 4) by twists in the base frame (c or 1, q, n or 1, 6)."""
    out = np.zeros((max(len(T), len(twists)), twists.shape[1], *T.shape[1:]))
    x, y, z = np.moveaxis(twists[..., 3:, None], -2, 0)
    along = T[:, None]
    out[..., 0, :] = y * along[..., 2, :] - z * along[..., 1, :]
    out[..., 1, :] = z * along[..., 0, :] - x * along[..., 2, :]
    out[..., 2, :] = x * along[..., 1, :] - y * along[..., 0, :]
    out[..., :3, 3] += twists[..., :3]
    return out
