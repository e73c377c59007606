"""How much of a residual is measurement error."""

from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.likelihood import NoiseLikelihood
from robolaser.model.noise.repeats import pixel_from_repeats

__all__ = ["NoiseLikelihood", "NoiseModel", "pixel_from_repeats"]
