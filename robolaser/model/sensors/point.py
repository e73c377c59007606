"""A tracker that stands in the cell and sees points on the flange."""

from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.estimation.elimination.loop import Loops
from robolaser.estimation.elimination.tracker import Room, follow
from robolaser.geometry.rigid_motion import carry
from robolaser.model.sensors.sensor import SIX, Sensor, motion, vector
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Parameters, Values

TURN = ("base.w", "base.phi", "base.psi")
HALF_TURN = np.pi


@final
class Point(Sensor):
    """Measured points P_world = T_world_base T_base_flange tool, a tool point for each reflector."""

    kind: ClassVar[str] = "point"
    stages: ClassVar[frozenset[Stage]] = Sensor.stages | {Stage.TARGET}

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

    @property
    def apart(self) -> tuple[tuple[tuple[str, ...], Ints], ...]:
        """Each axis of the tool points."""
        return tuple((tuple(f"tool.{name}.{axis}" for name in self._tools), self._tool) for axis in "xyz")

    def follow(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """The best of all, the middle angle within ±π/2."""
        everywhere = np.full(len(self.following), np.inf)
        everywhere[[self.following.index(name) for name in TURN]] = HALF_TURN
        return self._fitted(T_base_flange, perturb, -everywhere, everywhere)

    def complete(self, values: Values, T_base_flange: Array, perturb: Perturbation, bounds: Parameters) -> Values:
        """The best within bounds."""
        columns = bounds.columns(self.following)
        return self._fitted(T_base_flange, perturb, bounds.lower[columns], bounds.upper[columns])

    def _fitted(self, T_base_flange: Array, perturb: Perturbation, lower: Array, upper: Array) -> Values:
        measured = perturb(Stage.TARGET, self._measured)
        middle = measured.mean(axis=(0, 1))
        T = T_base_flange[:, self.dataset.points.pose]
        chi = np.concatenate([measured - middle, np.ones((*measured.shape[:2], 1))], axis=-1)
        loops = Loops.of(chi, np.eye(len(self._tools))[self._tool][None], T[..., :3, :3], T[..., :3, 3])
        swap = [*range(3, 6), *range(3), *range(6, len(lower))]
        offset = np.concatenate([np.zeros(3), middle, np.zeros(len(lower) - 6)])
        found = (follow(loops, Room(lower[swap] - offset, upper[swap] - offset)) + offset)[:, swap]
        return dict(zip(self.following, np.clip(found, lower, upper).T, strict=True))

    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Measured point less predicted point, in the world frame, (c, m, 3) [m]."""
        tools = np.stack([vector(values, f"tool.{name}") for name in self._tools], axis=1)
        T_world_flange = motion(values, "base")[:, None] @ T_base_flange
        seen = carry(T_world_flange, self.dataset.points.pose, tools[:, self._tool])
        return perturb(Stage.TARGET, self._measured) - seen
