"""A ball on the flange that is seated in fixed sockets, again and again, from many sides."""

from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.data.sensor_format import SensorFormat
from robolaser.geometry.rigid_motion import carry
from robolaser.model.error_source import ErrorSource, along_each_axis
from robolaser.model.grouped_rows import group_means
from robolaser.model.sensors.placements import places, vector
from robolaser.model.sensors.sensor import NewPoses, Perturbation, Sensor, SensorParameters, Values

MOST_APART = 4  # connected sockets that are each held out alone: two pairs would leave each fit half of the data
RANK = 1e-12  # of the largest eigenvalue: directions of the ball below are not determined


@final
class Socket(Sensor):
    """The ball's position T_base_flange tool.ball is the socket's, in every posture of the arm."""

    format: ClassVar[SensorFormat] = SensorFormat(
        kind="socket",
        title="ball in fixed sockets",
        columns={},
        absent={"x_m": 'a socket\'s place is not measured (kind "point" is)'},
        task="the model puts the ball",
        named_points="socket",
    )

    def __init__(self, dataset: Dataset) -> None:
        super().__init__(dataset)
        self._socket = dataset.points.number

    @cached_property
    def parameters(self) -> SensorParameters:
        """The ball in the flange frame and the sockets in the base frame."""
        things = ("tool.ball", *(f"socket.{name}" for name in self.names))
        return SensorParameters(derived=tuple(f"{thing}.{part}" for thing in things for part in "xyz"))

    def initialize(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """Linear least squares: R ball + t = socket for every row; each socket is the mean of its ball positions."""
        T = T_base_flange[:, self.dataset.points.pose]
        R, t = T[..., :3, :3], T[..., :3, 3]
        c, s = len(T), len(self.names)
        member = (self._socket == np.arange(s)[:, None]) / np.bincount(self._socket, minlength=s)[:, None]
        R_mean, t_mean = (member @ R.reshape(c, -1, 9)).reshape(c, s, 3, 3), member @ t
        A = (R - R_mean[:, self._socket]).reshape(c, -1, 3)
        b = (t_mean[:, self._socket] - t).reshape(c, -1, 1)
        inverse = np.linalg.pinv(np.swapaxes(A, 1, 2) @ A, rcond=RANK, hermitian=True)
        ball = (inverse @ (np.swapaxes(A, 1, 2) @ b))[..., 0]
        sockets = np.einsum("csij,cj->csi", R_mean, ball) + t_mean
        return dict(zip(self.parameters.derived, np.concatenate([ball, sockets.reshape(c, -1)], axis=1).T, strict=True))

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Socket less the ball's predicted position, in the base frame, (c, m, 3) [m]."""
        seated = carry(T_base_flange, self.dataset.points.pose, vector(values, "tool.ball")[:, None])
        return self.known(values, T_base_flange, perturb) - seated

    def known(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """The sockets, in the base frame, (c, m, 3) [m]."""
        return places(values, "socket", self.names)[:, self._socket]

    def row_errors(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Sequence[ErrorSource]:
        """`seat` [m], isotropic, each row's own."""
        m = len(self._socket)
        return [ErrorSource("seat", along_each_axis(m, 3), np.arange(m))]

    @property
    def new_poses(self) -> NewPoses:
        """None, since a seated arm cannot choose its pose; whole sockets are held out together."""
        return NewPoses(lambda *_: None, fold_groups=self._fold_groups(), relocated=self._relocated)

    def _fold_groups(self) -> Ints:
        """Whole sockets, with those at known distances from them, (m,).

        Where distances connect all sockets, each is held out with its nearest neighbour only, or alone. Distances to it
        stay in the fit, but do not improve it: they locate a socket that no pose of the fit touches.
        """
        whole = self._connected()
        if len(set(whole.values())) == 1:
            whole = self._in_pairs()
        order = {group: i for i, group in enumerate(dict.fromkeys(whole.values()))}
        return np.array([order[whole[name]] for name in self.dataset.points.names], dtype=np.int64)

    def _connected(self) -> dict[str, str]:
        """A socket for each, the same for all that known distances connect."""
        whole = {name: name for name in self.names}
        for one, other, _ in self.dataset.distances_m:
            old, new = whole.get(other, other), whole.get(one, one)
            whole = {name: new if group == old else group for name, group in whole.items()}
        return whole

    def _in_pairs(self) -> dict[str, str]:
        """A socket for each, the same for two that are nearest to each other; only itself where there are few."""
        whole: dict[str, str] = {}
        for one, other, _ in sorted(self.dataset.distances_m, key=lambda pair: pair[2]):
            if len(self.names) > MOST_APART and {one, other} <= set(self.names) - set(whole):
                whole |= {one: one, other: one}
        return {name: whole.get(name, name) for name in self.names}

    def _relocated(self, errors: Array) -> Array:
        """Errors from the mean of each socket's rows: a held-out socket is located from its own poses."""
        return np.asarray(errors - group_means(errors, self._socket)[self._socket])
