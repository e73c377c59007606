"""What a cell with given effects would record."""

from robolaser.simulation.effect_specs import sizes_of
from robolaser.simulation.simulate import Simulated, paper, simulate

__all__ = ["Simulated", "paper", "simulate", "sizes_of"]
