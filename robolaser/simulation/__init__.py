"""What a cell with given effects would record."""

from robolaser.simulation.effect_specs import sizes_of
from robolaser.simulation.setup import CellOptions
from robolaser.simulation.simulate import Simulated, paper, simulate

__all__ = ["CellOptions", "Simulated", "paper", "simulate", "sizes_of"]
