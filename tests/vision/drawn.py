"""Stripes drawn line by line, without a camera: Gaussian profiles integrated over the pixels' areas."""

import numpy as np
from scipy.ndimage import gaussian_filter

HEIGHT, WIDTH = 300, 640
ROW = np.arange(HEIGHT)
STRAIGHT = 318.3 + 0.0137 * ROW * 3
"""A line across a dozen pixels, so that every subpixel position occurs."""
WAVY = 320 + 0.13 * ROW + 4 * np.sin(ROW / 60)


def profile(middle, breadth, height):
    at = (np.arange(8 * WIDTH) + 0.5) / 8 - 0.5
    fine = height * np.exp(-0.5 * ((at - np.asarray(middle)[:, None]) / breadth) ** 2)
    return fine.reshape(len(middle), WIDTH, 8).mean(axis=-1)


def exposed(light, noise=0.0, seed=0):
    light = light + noise * np.random.default_rng(seed).standard_normal(light.shape)
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def speckled(light, contrast, seed=0):
    grain = gaussian_filter(np.random.default_rng(seed).standard_normal(light.shape), 0.7)
    return light * np.maximum(0, 1 + contrast * grain / grain.std())
