"""How much of a residual is measurement error."""

from robolaser.model.noise.covariance import NoiseModel, noise_from, noise_of, pixel_from_repeats, sizes_of

__all__ = ["NoiseModel", "noise_from", "noise_of", "pixel_from_repeats", "sizes_of"]
