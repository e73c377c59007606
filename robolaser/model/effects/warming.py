"""How far something has warmed up or settled in the course of a run: from 0 towards 1."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.course import rise
from robolaser.model.effects.effect import Scene

SHORTEST, LONGEST, USUAL = 0.05, 3.0, 0.3  # time constant over the length of the run
TRIED = 6  # time constants; two neighbours' curves agree to a few per cent


def warmed(scene: Scene, tau: Array) -> Array:
    """Rise of temperature over its largest where it was measured, else 1 - exp(-progress / tau), (c,) -> (c or 1, n).

    Source: Newton's law of cooling, towards a constant temperature.
    """
    return scene.rise[None] if scene.rise is not None else -np.expm1(-scene.progress / tau[:, None])


def time_constants(dataset: Dataset) -> Array:
    """Time constants worth trying, (g, 1): where a thermometer was read they mean nothing, and one will do."""
    known = rise(dataset.poses) is not None
    return np.array([[USUAL]]) if known else np.geomspace(SHORTEST, LONGEST, TRIED)[:, None]
