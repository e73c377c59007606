"""Images that are taken while the arm moves, later or earlier than its joints are read."""

from dataclasses import dataclass
from typing import ClassVar, final

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter
from robolaser.model.effects.lacking import no_velocities
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class Latency(Effect):
    r"""The arm moved on between encoder reading and exposure: :math:`q' = q + \dot q\,\mathrm{delay}`."""

    name: ClassVar[str] = "latency"
    title: ClassVar[str] = "the exposure is later (or earlier) than the reading of the joint angles"
    reference: ClassVar[str] = "Furgale, Rehder, Siegwart 2013, Unified temporal and spatial calibration; 20-200 ms"
    stage: ClassVar[Stage] = Stage.JOINTS

    delay: Array = parameter(unit="s", bound=0.5, prior_scale=0.02)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """Velocities."""
        return no_velocities(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The timing of sensor and robot."""
        return () if cls.missing(dataset) else ("timing",)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Let every joint move on."""
        assert scene.poses.qd is not None  # `missing` says so
        return value + self.delay[:, None, None] * scene.poses.qd
