"""What a cell with given effects would record."""

from robolaser.simulation.cell import Simulated, paper, simulate
from robolaser.simulation.effect_specs import sizes_of

__all__ = ["Simulated", "paper", "simulate", "sizes_of"]
