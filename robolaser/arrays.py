"""The kinds of array that pass through robolaser."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Image = NDArray[np.uint8]
Progress = Callable[[str, float], None]  # called by long work with its current step, in words, and its finished share
