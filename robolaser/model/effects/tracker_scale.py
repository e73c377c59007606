"""Trackers with a scale error."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.requirements import own_lengths


@final
@dataclass(frozen=True)
class TrackerScale(Effect):
    """All measured lengths are too long by a share: P' = P / (1 + scale), from the measuring system's origin.

    Air a kelvin colder than the instrument assumes changes an interferometer by 1e-6; scale bars of photogrammetry are
    good to 1e-5, and a stereo camera whose baseline creeps is off by 1e-3. An arm whose links are all too short looks
    the same: known distances distinguish them.
    """

    name = "tracker_scale"
    title = "scale error of the measuring system"
    clause = "the scale of the measuring system is wrong"
    caveat = "links that are all too long or too short look the same, unless distances between points are known"
    remedy = "Check the measuring system against a scale bar, and its air temperature and pressure."
    reference = "Muralikrishnan, Phillips, Sawyer 2016, Laser trackers for large-scale dimensional metrology: a review"
    stage = Stage.TARGET
    cause = "measuring_system"
    site = "measuring_system"
    needs = (own_lengths,)
    looks_like_arm = True

    scale: Array = parameter(unit="", bound=0.02, prior_scale=2e-4)

    def apply(self, points: Array, run: Run, /) -> Array:
        return points / (1.0 + self.scale[:, None, None])
