"""Images taken while the arm moves, later or earlier than its joints are read."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.requirements import velocities


@final
@dataclass(frozen=True)
class Latency(Effect):
    r"""The arm moved on between reading and exposure: :math:`q' = q + \dot q\,\mathrm{delay}`, or the flange does so.

    Where flange poses were measured, :math:`T' = T\,(\exp(\omega\,\mathrm{delay}), v\,\mathrm{delay})`.
    """

    name = "latency"
    title = "the exposure is later (or earlier) than the reading of the joint angles"
    clause = "exposure and joint reading are not simultaneous"
    caveat = "assumes that the velocities in the data, or else those along the path, are those at the exposure"
    remedy = "Trigger the camera and read the joints together, or stop for each exposure."
    reference = "Furgale, Rehder, Siegwart 2013, Unified temporal and spatial calibration; 20-200 ms"
    stage = Stage.JOINTS
    cause = "timing"
    site = "timing"
    needs = (velocities,)

    delay: Array = parameter(unit="s", bound=0.5, prior_scale=0.02)

    @classmethod
    def stage_in(cls, dataset: Dataset) -> Stage:
        """Joint angles, or measured poses of the flange."""
        return cls.stage if dataset.robot is not None else Stage.FLANGE

    def apply(self, value: Array, run: Run, /) -> Array:
        """Let every joint move on, (c, n, j), or the flange, (c, n, 4, 4)."""
        way = self.delay[:, None, None] * run.qd
        return value + way if value.ndim == 3 else value @ pose(exp_so3(way[..., 3:]), way[..., :3])
