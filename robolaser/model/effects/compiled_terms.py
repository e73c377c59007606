"""Terms of optics that the compiled loop over scanned points knows, by the number that comes first in a term."""

from typing import Final

RADIAL: Final = 1.0  # radial distortion: k_2 [1/m⁴], 0
TANGENTIAL: Final = 2.0  # tangential distortion: p_1, p_2 [1/m]
