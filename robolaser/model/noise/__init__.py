"""How much of a residual is measurement error."""

from robolaser.model.noise.covariance import NoiseModel, noise_from, noise_of, sizes_of
from robolaser.model.noise.repeats import pixel_from_repeats
from robolaser.model.noise.two_units import comparable

__all__ = ["NoiseModel", "comparable", "noise_from", "noise_of", "pixel_from_repeats", "sizes_of"]
