"""The operators of the genetic algorithm of Lee et al. 2004, for pymoo's algorithms."""

from robolaser.operators.arithmetic_crossover import ArithmeticCrossover
from robolaser.operators.elitist_replacement import ElitistReplacement
from robolaser.operators.non_uniform_mutation import NonUniformMutation
from robolaser.operators.roulette_selection import RouletteSelection

__all__ = ["ArithmeticCrossover", "ElitistReplacement", "NonUniformMutation", "RouletteSelection"]
