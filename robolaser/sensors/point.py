"""A tracker that stands in the cell and sees points on the flange."""

from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.dataset import Dataset
from robolaser.parameters import Values
from robolaser.se3 import apply, exp_so3, inverse, pose, rigid_fit
from robolaser.seams import Bend, Seam
from robolaser.sensors.sensor import SIX, Sensor, motion, six_of, vector

STARTS = 64  # turns of the base tried by the closed form; two in three lead home
ROUNDS = 40  # of base given tools, tools given base
ROWS = 300  # enough for a start


@final
class Point(Sensor):
    """Measured points P_world = T_world_base T_base_flange tool, a tool point for each reflector."""

    kind: ClassVar[str] = "point"

    def __init__(self, dataset: Dataset) -> None:
        super().__init__(dataset)
        assert dataset.points.xyz is not None  # the folder's reader sees to it
        self._measured = dataset.points.xyz[None]
        self._tools = tuple(dict.fromkeys(dataset.points.names))
        self._tool = np.array([self._tools.index(name) for name in dataset.points.names], dtype=np.int64)

    @property
    def own(self) -> tuple[str, ...]:
        """None: everything follows from the measurements."""
        return ()

    @property
    def following(self) -> tuple[str, ...]:
        """T_world_base and the tool points."""
        tools = (f"tool.{name}.{part}" for name in self._tools for part in "xyz")
        return (*(f"base.{part}" for part in SIX), *tools)

    def follow(self, values: Values, T_base_flange: Array, bend: Bend) -> Values:
        """Base and tools in turn, each the best for the other, from many turns of the base at once.

        Given tools, the base is a rigid fit; given the base, each tool is a mean. The same start serves all
        candidates, so this is a start for a polish and no more.
        """
        rows = np.unique(np.linspace(0, len(self._tool) - 1, min(ROWS, len(self._tool))).astype(int))
        tool = self._tool[rows]
        measured = bend(Seam.TARGET, self._measured)[:1, rows]
        T = T_base_flange[:1, self.dataset.points.pose[rows]]
        turns = np.random.default_rng(0).normal(size=(STARTS, 3)) * 2.0
        turns[0] = 0.0
        T_world_base = pose(exp_so3(turns), np.zeros((STARTS, 3)))
        middle = measured.mean(axis=1) - apply(T_world_base[:, None], T[..., :3, 3]).mean(axis=1)
        T_world_base[:, :3, 3] = middle
        for _ in range(ROUNDS):
            in_flange = apply(inverse(T), apply(inverse(T_world_base)[:, None], measured))
            tools = np.stack([in_flange[:, tool == i].mean(axis=1) for i in np.unique(tool)], axis=1)
            seen = apply(T, tools[:, np.searchsorted(np.unique(tool), tool)])
            T_world_base = rigid_fit(seen, np.broadcast_to(measured, seen.shape))
        misfit = ((apply(T_world_base[:, None], seen) - measured) ** 2).sum(axis=(1, 2))
        best = int(np.argmin(misfit))
        found = six_of(T_world_base[best : best + 1], "base")
        for i, name in enumerate(self._tools):
            place = in_flange[best, tool == i].mean(axis=0) if (tool == i).any() else np.zeros(3)
            found |= {f"tool.{name}.{part}": place[j : j + 1] for j, part in enumerate("xyz")}
        return found

    def residuals(self, values: Values, T_base_flange: Array, bend: Bend) -> Array:
        """Measured point less predicted point, in the world frame, (c, m, 3) [m]."""
        tools = np.stack([vector(values, f"tool.{name}") for name in self._tools], axis=1)
        T_world_flange = motion(values, "base")[:, None] @ T_base_flange
        seen = apply(T_world_flange[:, self.dataset.points.pose], tools[:, self._tool])
        return bend(Seam.TARGET, self._measured) - seen
