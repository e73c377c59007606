"""Images that are taken while the arm moves, later or earlier than its joints are read."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, parameter
from robolaser.model.effects.requirements import velocities
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class Latency(Effect):
    r"""The arm moved on between encoder reading and exposure: :math:`q' = q + \dot q\,\mathrm{delay}`."""

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

    def apply(self, q: Array, run: Run, /) -> Array:
        """Let every joint move on."""
        return q + self.delay[:, None, None] * run.qd
