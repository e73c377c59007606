"""Overhead of a generation: RCGA, the same algorithm of pymoo's parts, and pymoo's GA."""

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from pymoo.algorithms.base.genetic import GeneticAlgorithm
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.problem import Problem
from pymoo.operators.sampling.rnd import FloatRandomSampling

from robolaser.algorithms import RCGA
from robolaser.operators import ArithmeticCrossover, ElitistReplacement, NonUniformMutation, RouletteSelection

VARIABLES = 14
POPULATION = 100


class Bowl(Problem):
    """A cost that is cheap to evaluate."""

    def __init__(self) -> None:
        super().__init__(n_var=VARIABLES, n_obj=1, xl=-1.0, xu=1.0)

    def _evaluate(self, X: Any, out: Any, *args: Any, **kwargs: Any) -> None:
        out["F"] = ((X - 0.2) ** 2).sum(axis=1)


def composed() -> GeneticAlgorithm:
    return GeneticAlgorithm(
        pop_size=POPULATION,
        n_offsprings=POPULATION - 10,
        sampling=FloatRandomSampling(),
        selection=RouletteSelection(),
        crossover=ArithmeticCrossover(prob=0.85),
        mutation=NonUniformMutation(prob_var=0.1, b=5.0),
        survival=ElitistReplacement(10),
        eliminate_duplicates=False,
    )


CASES: dict[str, tuple[Callable[[], Any], int]] = {
    "RCGA": (lambda: RCGA(POPULATION), 20),
    "the same of pymoo's parts": (composed, 1),
    "pymoo's GA, its defaults": (lambda: GA(POPULATION), 1),
}


def milliseconds(case: str, generations: int) -> float:
    """CPU time of a generation in the middle of a long run."""
    make, times = CASES[case]
    algorithm = make().setup(Bowl(), termination=("n_gen", 10_000), seed=1)
    for _ in range(10):
        algorithm.next()
    n = times * generations
    began = time.process_time()
    for _ in range(n):
        algorithm.next()
    return 1e3 * (time.process_time() - began) / n


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--repeats", type=int, default=5)
    options.add_argument("--generations", type=int, default=100)
    args = options.parse_args()

    measured = np.array([[milliseconds(case, args.generations) for case in CASES] for _ in range(args.repeats)])
    ratios = measured[:, -1:] / measured
    print("| | CPU ms a generation | GA's time relative to it |")
    print("|---|---|---|")
    for i, case in enumerate(CASES):
        print(f"| {case} | {spread(measured[:, i], '.3f')} | {spread(ratios[:, i], '.1f')} |")


def spread(values: Any, digits: str) -> str:
    low, median, high = np.percentile(values, [0, 50, 100])
    return f"{median:{digits}} ({low:{digits}} .. {high:{digits}})"


if __name__ == "__main__":
    main()
