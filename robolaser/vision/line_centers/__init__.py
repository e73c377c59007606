"""Ways from a stripe's profile to its middle: each takes runs and their profiles, and gives middle and deviation."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from robolaser.arrays import Array
from robolaser.vision.line_centers.center_of_gravity import Profiles, mass
from robolaser.vision.line_centers.gauss import gauss
from robolaser.vision.line_centers.steger import steger
from robolaser.vision.runs import Runs

Centring = Callable[[Runs, Profiles], tuple[Array, Array]]

CENTRINGS: Mapping[str, Centring] = MappingProxyType({"mass": mass, "gauss": gauss, "steger": steger})
"""Each by the name it is chosen by."""
SMOOTHING = frozenset({"steger"})
"""Those whose middles share their neighbours' noise: the scatter along the stripe does not tell it."""
DEFAULT = "gauss"
"""Near what noise allows where the profile is a bell, and the centre of mass where it is glare."""
