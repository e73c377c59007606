"""Simulated recordings of a cell with given effects."""

from robolaser.simulation.effect_specs import sizes_of
from robolaser.simulation.setup import CellOptions
from robolaser.simulation.simulate import Simulated, paper, simulate

__all__ = ["CellOptions", "Simulated", "paper", "simulate", "sizes_of"]
