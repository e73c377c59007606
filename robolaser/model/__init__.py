"""The forward model: stages from encoder and image to a residual, sensors, effects and noise."""
