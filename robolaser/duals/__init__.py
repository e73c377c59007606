"""Dual numbers: arrays that carry their derivatives by parameters through NumPy code."""

from robolaser.duals.dual import LINEAR, PARTIALS, Dual, bare, is_dual, joined, slopes_of
from robolaser.duals.functions import RULES

__all__ = ["LINEAR", "PARTIALS", "RULES", "Dual", "bare", "is_dual", "joined", "slopes_of"]
