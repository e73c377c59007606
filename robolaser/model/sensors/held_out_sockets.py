"""Sockets that cross-validation leaves out whole."""

from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.model.sensors.held_out import HeldOut

MOST_APART = 4  # connected sockets that are each held out alone: two pairs would leave each fit half of the data


@final
class HeldOutSockets(HeldOut):
    """No pose of the fit touches a socket that is held out."""

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset
        self._sockets = tuple(dict.fromkeys(dataset.points.names))
        self._socket = dataset.points.number

    @property
    def groups(self) -> Ints:
        """Whole sockets, with those at known distances from them, (m,).

        Where distances connect all sockets, each is held out with its nearest neighbour only, or alone. Distances to it
        stay in the fit, which they cannot help: they say where a socket is that no pose of the fit touches.
        """
        whole = self._connected()
        if len(set(whole.values())) == 1:
            whole = self._in_pairs()
        order = {group: i for i, group in enumerate(dict.fromkeys(whole.values()))}
        return np.array([order[whole[name]] for name in self._dataset.points.names], dtype=np.int64)

    def _connected(self) -> dict[str, str]:
        """A socket for each, the same for all that known distances connect."""
        whole = {name: name for name in self._sockets}
        for one, other, _ in self._dataset.distances_m:
            old, new = whole.get(other, other), whole.get(one, one)
            whole = {name: new if group == old else group for name, group in whole.items()}
        return whole

    def _in_pairs(self) -> dict[str, str]:
        """A socket for each, the same for two that are nearest to each other; only itself where there are few."""
        whole: dict[str, str] = {}
        for one, other, _ in sorted(self._dataset.distances_m, key=lambda pair: pair[2]):
            if len(self._sockets) > MOST_APART and {one, other} <= set(self._sockets) - set(whole):
                whole |= {one: one, other: one}
        return {name: whole.get(name, name) for name in self._sockets}

    def located_apart(self, errors: Array) -> Array:
        """From the mean of each socket's rows: one that was held out is located from its own poses."""
        counts = np.bincount(self._socket)[:, None]
        sums = np.stack([np.bincount(self._socket, errors[:, axis]) for axis in range(3)], axis=-1)
        return np.asarray(errors - (sums / counts)[self._socket])
