"""The operators of the genetic algorithm of Lee et al. 2004 and their classical kin, for pymoo's algorithms."""

from robolaser.operators.arithmetic_crossover import ArithmeticCrossover
from robolaser.operators.blend_crossovers import (
    BlendCrossover,
    ExtendedArithmeticCrossover,
    HeuristicCrossover,
    SimpleCrossover,
)
from robolaser.operators.elitist_replacement import ElitistReplacement
from robolaser.operators.gene_mutations import BoundaryMutation, UniformMutation
from robolaser.operators.non_uniform_mutation import NonUniformMutation
from robolaser.operators.roulette_selection import RouletteSelection, StochasticUniversalSampling

__all__ = [
    "ArithmeticCrossover",
    "BlendCrossover",
    "BoundaryMutation",
    "ElitistReplacement",
    "ExtendedArithmeticCrossover",
    "HeuristicCrossover",
    "NonUniformMutation",
    "RouletteSelection",
    "SimpleCrossover",
    "StochasticUniversalSampling",
    "UniformMutation",
]
