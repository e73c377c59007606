"""A ball on the flange that is seated in fixed sockets, again and again, from many sides."""

from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.estimation.elimination.seats import seat
from robolaser.geometry.rigid_motion import carry
from robolaser.model.sensors.sensor import Sensor, vector
from robolaser.model.stages import Perturbation
from robolaser.parameters import Parameters, Values


@final
class Socket(Sensor):
    """The ball's place T_base_flange tool.ball is the socket's, whichever way the arm is folded."""

    kind: ClassVar[str] = "socket"

    def __init__(self, dataset: Dataset) -> None:
        super().__init__(dataset)
        self._sockets = tuple(dict.fromkeys(dataset.points.names))
        self._socket = np.array([self._sockets.index(name) for name in dataset.points.names], dtype=np.int64)

    @property
    def own(self) -> tuple[str, ...]:
        """None: everything follows from the readings."""
        return ()

    @property
    def following(self) -> tuple[str, ...]:
        """The ball in the flange frame and the sockets in the base frame."""
        sockets = (f"socket.{name}.{part}" for name in self._sockets for part in "xyz")
        return (*(f"tool.ball.{part}" for part in "xyz"), *sockets)

    @property
    def apart(self) -> tuple[tuple[tuple[str, ...], Ints], ...]:
        """Each axis of the sockets."""
        return tuple((tuple(f"socket.{name}.{axis}" for name in self._sockets), self._socket) for axis in "xyz")

    def follow(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """Linear least squares: R ball + t = socket for every row, exact in one step."""
        everywhere = np.full(len(self.following), np.inf)
        return self._seated(T_base_flange, -everywhere, everywhere)

    def complete(self, values: Values, T_base_flange: Array, perturb: Perturbation, bounds: Parameters) -> Values:
        """The same within bounds."""
        columns = bounds.columns(self.following)
        return self._seated(T_base_flange, bounds.lower[columns], bounds.upper[columns])

    def _seated(self, T_base_flange: Array, lower: Array, upper: Array) -> Values:
        T = T_base_flange[:, self.dataset.points.pose]
        ball, sockets = seat(T[..., :3, :3], T[..., :3, 3], self._socket, lower, upper)
        found = np.concatenate([ball, sockets.reshape(len(T), -1)], axis=1)
        return dict(zip(self.following, found.T, strict=True))

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Socket less the ball's predicted place, in the base frame, (c, m, 3) [m]."""
        sockets = np.stack([vector(values, f"socket.{name}") for name in self._sockets], axis=1)
        ball = vector(values, "tool.ball")
        seated = carry(T_base_flange, self.dataset.points.pose, ball[:, None])
        return sockets[:, self._socket] - seated

    @property
    def held_out_groups(self) -> Ints:
        """Whole sockets, with those at known distances from them, (m,)."""
        whole = {name: name for name in self._sockets}
        for one, other, _ in self.dataset.distances_m:
            old, new = whole.get(other, other), whole.get(one, one)
            whole = {name: new if group == old else group for name, group in whole.items()}
        order = {group: i for i, group in enumerate(dict.fromkeys(whole.values()))}
        return np.array([order[whole[name]] for name in self.dataset.points.names], dtype=np.int64)

    def located_apart(self, errors: Array) -> Array:
        """From the mean of each socket's rows: one that was held out is located from its own poses."""
        counts = np.bincount(self._socket)[:, None]
        sums = np.stack([np.bincount(self._socket, errors[:, axis]) for axis in range(3)], axis=-1)
        return np.asarray(errors - (sums / counts)[self._socket])
