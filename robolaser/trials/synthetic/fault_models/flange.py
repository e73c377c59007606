"""Faults between the base and the target."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class BumpedBase(FaultModel):
    """Somebody bumps into the base or the target during the run: from one pose on, everything stands elsewhere."""

    effect: ClassVar[str] = "base_shift"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 1.5e-3)
    location: ClassVar[str | None] = "base"

    moment: float
    way: tuple[float, ...]

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """When, as a share of the run, and which way."""
        return rng.uniform(0.2, 0.8), tuple(rng.uniform(-1.0, 1.0, 6).tolist())

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's numbers."""
        way, middle = self.size * np.array(self.way), run.arm.forward(run.q)[:, :3, 3].mean(axis=0)
        apart = middle - run.middle
        shift = way[:3] + Rotation.from_rotvec(way[3:]).apply(apart) - apart
        names = ("x", "y", "z", "turn_x", "turn_y", "turn_z", "moment")
        return dict(zip(names, (*shift.tolist(), *way[3:].tolist(), self.moment), strict=True))

    def flange(self, T_base_flange: Array, run: SyntheticRun) -> Array:
        """Moved by up to `size` [m] and turned by up to as many radians, about the target."""
        way = self.size * np.array(self.way)
        bump = np.eye(4)
        bump[:3, :3] = Rotation.from_rotvec(way[3:]).as_matrix()
        bump[:3, 3] = way[:3] + run.middle - bump[:3, :3] @ run.middle
        return np.where((run.share > self.moment)[:, None, None], bump @ T_base_flange, T_base_flange)


@final
@dataclass(frozen=True)
class YieldingFloor(FaultModel):
    """The floor gives way under the arm's overturning moment, and under an edge of the foot more than under another.

    Anchors that are pressed down are stiffer than those that are pulled.
    """

    effect: ClassVar[str] = "base_compliance"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 3e-3)
    location: ClassVar[str | None] = "base"

    softer: float
    pulled: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """How much softer it is about x than about y, and how much an anchor yields more to a pull."""
        return rng.uniform(-0.3, 0.3), rng.uniform(0.0, 0.15)

    def flange(self, T_base_flange: Array, run: SyntheticRun) -> Array:
        """Tilted about the foot, by `size` [rad] under the largest moment of the run."""
        moment = run.arm.overturning(run.q, run.payload_kg)
        load = moment / max(1e-9, float(np.linalg.norm(moment, axis=1).max()))
        load = load * (1.0 + self.pulled * np.tanh(3.0 * load)) * [1.0 + self.softer, 1.0 - self.softer, 0.0]
        tilt = np.tile(np.eye(4), (len(load), 1, 1))
        tilt[:, :3, :3] = Rotation.from_rotvec(self.size * load).as_matrix()
        return tilt @ T_base_flange
