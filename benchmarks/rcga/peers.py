"""What a generation costs beside evaluating it, at four sizes, beside pymoo's GA, SciPy's search and pycma.

CPU time of a generation in the middle of a run on a cost that costs next to nothing, all in one run, in turn.
"""

import argparse
import time
import warnings
from collections.abc import Callable
from typing import Any

import cma
import numpy as np
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.problem import Problem
from scipy.optimize import differential_evolution

from robolaser.algorithms import RCGA

SIZES = ((100, 14), (100, 100), (1000, 14), (1000, 100))
"""Population and variables."""


def bowl(X: Any) -> Any:
    return (X[..., 0] - 0.2) ** 2


class Bowl(Problem):
    """A cost that costs next to nothing."""

    def __init__(self, variables: int) -> None:
        super().__init__(n_var=variables, n_obj=1, xl=-1.0, xu=1.0)

    def _evaluate(self, X: Any, out: Any, *args: Any, **kwargs: Any) -> None:
        out["F"] = bowl(X)


class Enough(Exception):
    """So many generations were measured."""


def of_pymoo(make: Callable[[int], Any], population: int, variables: int, generations: int) -> float:
    algorithm = make(population).setup(Bowl(variables), termination=("n_gen", 10**6), seed=1)
    for _ in range(5):
        algorithm.next()
    began = time.process_time()
    for _ in range(generations):
        algorithm.next()
    return time.process_time() - began


def of_scipy(population: int, variables: int, generations: int) -> float:
    moments = []

    def costs(x: Any) -> Any:
        moments.append(time.process_time())
        if len(moments) > generations + 5:
            raise Enough
        return bowl(x.T)

    start = np.random.default_rng(1).uniform(-1, 1, (population, variables))
    try:
        differential_evolution(
            costs, [(-1, 1)] * variables, init=start, vectorized=True, updating="deferred", polish=False, tol=0, seed=1
        )
    except Enough:
        return moments[-1] - moments[-1 - generations]
    raise RuntimeError("it converged before it was measured")


def of_pycma(population: int, variables: int, generations: int) -> float:
    options = {"popsize": population, "bounds": [-1, 1], "seed": 1, "verbose": -9}
    search = cma.CMAEvolutionStrategy(variables * [0.5], 0.3, options)

    def generation() -> None:
        X = search.ask()
        search.tell(X, bowl(np.array(X)).tolist())

    generation()
    began = time.process_time()
    for _ in range(generations):
        generation()
    return time.process_time() - began


def of_draws(population: int, variables: int, generations: int) -> float:
    """The random numbers of a generation of RCGA, and nothing else."""
    rng, pairs = np.random.default_rng(1), (RCGA(population).n_offsprings + 1) // 2
    genes = 2 * pairs * variables
    began = time.process_time()
    for _ in range(generations):
        rng.random(3 * pairs)  # the wheel, and who crosses
        rng.random(pairs)  # shares
        rng.random(genes)  # which genes move
        rng.random(2 * (genes // 10) + 2 * pairs)  # which way and how far
    return time.process_time() - began


CASES: dict[str, tuple[Callable[[int, int, int], float], int]] = {
    "RCGA": (lambda *size: of_pymoo(RCGA, *size), 20),
    "pymoo's GA": (lambda *size: of_pymoo(GA, *size), 1),
    "SciPy's DE, vectorised": (of_scipy, 5),
    "pycma": (of_pycma, 1),
    "RCGA's draws alone": (of_draws, 50),
}
"""What is measured, and how many times as many generations as the slowest can be afforded."""


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--repeats", type=int, default=5)
    options.add_argument("--generations", type=int, default=10)
    args = options.parse_args()
    warnings.simplefilter("ignore")
    print("| CPU ms a generation, median | " + " | ".join(f"{n} × {d}" for n, d in SIZES) + " |")
    print("|---" * (1 + len(SIZES)) + "|")
    measured = np.empty((len(CASES), len(SIZES), args.repeats))
    for repeat in range(args.repeats):
        for j, size in enumerate(SIZES):
            for i, (case, times) in enumerate(CASES.values()):
                generations = args.generations * times
                measured[i, j, repeat] = 1e3 * case(*size, generations) / generations
    for name, of_sizes in zip(CASES, np.median(measured, axis=2), strict=True):
        print(f"| {name} | " + " | ".join(f"{value:.3g}" for value in of_sizes) + " |")
    ratios = np.median(measured[0] / measured, axis=2)
    shares = ratios[list(CASES).index("RCGA's draws alone")]
    print("| RCGA, over its draws | " + " | ".join(f"{value:.1f}" for value in shares) + " |")
    print("| share of the draws | " + " | ".join(f"{100 / value:.0f} %" for value in shares) + " |")


if __name__ == "__main__":
    main()
