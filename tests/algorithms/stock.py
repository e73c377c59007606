"""The paper's algorithm assembled from pymoo's parts: the reference for RCGA."""

from pymoo.algorithms.base.genetic import GeneticAlgorithm
from pymoo.operators.sampling.rnd import FloatRandomSampling

from robolaser.operators import ArithmeticCrossover, ElitistReplacement, NonUniformMutation, RouletteSelection


def composed(pop_size, n_elites, *, prob_crossover=0.85, sampling=None, survival=None, **mutation):
    """The same algorithm as `RCGA(pop_size, n_elites=n_elites, ...)`, with an Individual for each candidate."""
    return GeneticAlgorithm(
        pop_size=pop_size, n_offsprings=pop_size - n_elites,
        sampling=FloatRandomSampling() if sampling is None else sampling, selection=RouletteSelection(),
        crossover=ArithmeticCrossover(prob=prob_crossover),
        mutation=NonUniformMutation(**{"prob_var": 0.1, "b": 5.0, **mutation}),
        survival=ElitistReplacement(n_elites), eliminate_duplicates=False,
    )  # fmt: skip
