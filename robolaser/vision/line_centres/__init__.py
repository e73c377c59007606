"""Subpixel peak detectors: each takes runs and their profiles, and gives centre and standard deviation."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from robolaser.arrays import Array
from robolaser.vision.line_centres.gaussian_fit import gaussian_fit
from robolaser.vision.line_centres.steger import steger
from robolaser.vision.profiles import Profiles
from robolaser.vision.runs import Runs

PeakDetector = Callable[[Runs, Profiles], tuple[Array, Array]]

PEAK_DETECTORS: Mapping[str, PeakDetector] = MappingProxyType({"gauss": gaussian_fit, "steger": steger})
"""Each by its name."""
SMOOTHING = frozenset({"steger"})
"""Those whose centres share their neighbours' noise: the scatter along the stripe is not their noise."""
DEFAULT = "gauss"
"""Near what noise allows where the profile is a Gaussian, and the centre of gravity where it is glare."""
