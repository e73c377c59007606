"""Faults of joints in forms that no library has."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models.joint_loads import GearWindup
from robolaser.trials.synthetic.fault_models.joints import play_lag, turned
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class HystereticWindup(FaultModel):
    """A joint gives way under its torque, by `size` [rad] at most, and comes back only once friction is overcome."""

    effect: ClassVar[str] = "hysteresis"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 3e-3)
    classes: ClassVar[tuple[str, ...]] = ("elasticity", "transmission")

    friction: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Width of the hysteresis over the range of the torque."""
        return (float(rng.uniform(0.2, 0.7)),)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Where a joint's compliance could be named."""
        return GearWindup.locations(run)

    @property
    def also_right(self) -> tuple[tuple[str, str], ...]:
        """Its two halves."""
        return (("joint_compliance", self.where), ("backlash", self.where))

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """By the torque less a play operator's lag, along the poses in the order of time."""
        column = run.column(self.where)
        torque = run.arm.torques(run.q, run.payload_kg)[:, column]
        load = torque / max(1e-9, float(np.abs(torque).max()))
        width, lag, lags = self.friction * float(np.ptp(load)), 0.0, np.empty(len(q))
        along = load[run.order]
        for row, move in zip(run.order, np.diff(along, prepend=along[0]), strict=True):
            lags[row] = lag = play_lag(lag, float(move), width)
        return turned(q, column, -self.size * (load - lags))


@final
@dataclass(frozen=True)
class UncountedTurn(FaultModel):
    """A dead zone: across some range of a joint an encoder's reading falls behind, by `size` [rad] from end to end."""

    effect: ClassVar[str] = "dead_zone"
    sizes: ClassVar[tuple[float, float]] = (4e-4, 4e-3)
    signed: ClassVar[bool] = True
    classes: ClassVar[tuple[str, ...]] = ("transmission",)

    middle: float
    width: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Where in the range of the run, 0 to 1, and how wide."""
        return float(rng.uniform(0.3, 0.7)), float(rng.uniform(0.05, 0.25))

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Behind by half of it on one side, ahead on the other: the zero was set in the middle."""
        column = run.column(self.where)
        read = run.q[:, column]
        share = (read - read.min()) / max(1e-9, float(np.ptp(read)))
        return turned(q, column, self.size * np.clip((share - self.middle) / self.width, -0.5, 0.5))


@final
@dataclass(frozen=True)
class SlippedCoupling(FaultModel):
    """A coupling slips at some moment of the run: from there on the joint's zero is off by `size` [rad]."""

    effect: ClassVar[str] = "slipping"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 4e-3)
    signed: ClassVar[bool] = True
    classes: ClassVar[tuple[str, ...]] = ("transmission",)

    moment: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """When, as a share of the run."""
        return (float(rng.uniform(0.25, 0.75)),)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """All but the first and the last, which could as well be the base or the bracket."""
        return run.arm.joints[1:-1]

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Off since then."""
        return turned(q, run.column(self.where), np.where(run.share > self.moment, self.size, 0.0))
