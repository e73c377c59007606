"""Common units of lengths, angles and times, in SI units."""

from collections.abc import Mapping
from typing import Final

import numpy as np

LENGTH: Final = "lengths"
ANGLE: Final = "angles"
TIME: Final = "times"
FACTORS: Mapping[str, Mapping[str, float]] = {  # each unit in metres, radians or seconds
    LENGTH: {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254},
    ANGLE: {"rad": 1.0, "mrad": 1e-3, "deg": np.pi / 180.0, "arcsec": np.pi / 648_000.0},
    TIME: {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
}
