"""What a cell with given effects would record."""

from robolaser.simulate.cell import Simulated, paper, simulate
from robolaser.simulate.wanted import sizes_of

__all__ = ["Simulated", "paper", "simulate", "sizes_of"]
