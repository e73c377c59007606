"""Repeatability: the scatter of whole poses, which is noise."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.diagnosis.fit import Fit
from robolaser.estimation.certainty import EVEN
from robolaser.model.noise.covariance import NoiseModel, Origin


@final
@dataclass(frozen=True)
class NoiseSource:
    """The size of a source of noise."""

    value: float  # standard deviation
    unit: str
    origin: Origin
    of_poses: bool  # whether it moves whole poses


@final
@dataclass(frozen=True)
class Repeatability:
    """The scatter of whole poses."""

    sources: Mapping[str, NoiseSource]  # its sources by name: joint readings, flange poses, a tracker's probe
    at_sensor_m: float  # resulting root-mean-square 3-D error of a row [m]
    is_stated: bool = False  # whether the data set states the arm's repeatability

    def is_most_of(self, floor_m: float) -> bool:
        """Whether it is reported: it is not stated, and is most of a row's noise.

        Without scatter of poses, chance makes a third of the noise look like it.
        """
        is_estimated = any(source.origin != "stated" for source in self.sources.values())
        return is_estimated and self.at_sensor_m > EVEN * floor_m


def noise_sources(noise: NoiseModel) -> dict[str, NoiseSource]:
    """The sources of noise, by name."""
    return {
        source.name: NoiseSource(
            float(noise.sigmas[source.name]),
            source.unit,
            noise.origin.get(source.name, "stated"),
            source.level == "pose",
        )
        for source in noise.sources
    }


def repeatability_of(fit: Fit, noise: NoiseModel) -> Repeatability:
    """The scatter of whole poses, without row noise."""
    of_poses = noise.at({source.name: 0.0 for source in noise.sources if source.level != "pose"})
    zero = noise.at(dict.fromkeys(noise.sigmas, 0.0))
    sources = {name: source for name, source in noise_sources(noise).items() if source.of_poses}
    stated = fit.model.dataset.noise.repeatability_m
    return Repeatability(
        sources, float(np.sqrt(fit.size_of(of_poses) ** 2 - fit.size_of(zero) ** 2)), stated is not None
    )
