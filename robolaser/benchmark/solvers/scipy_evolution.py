"""SciPy's differential evolution, restarted whenever it ends."""

from itertools import chain, repeat
from typing import Any, ClassVar, final

import numpy as np

from robolaser.algorithms.settings import Setting, number, share, switch, whole, word
from robolaser.arrays import Array
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.solvers.solver import Solver, within

STRATEGIES = tuple(
    f"{parents}1{crossover}"
    for parents in ("best", "rand", "currenttobest", "randtobest")
    for crossover in ("bin", "exp")
)


@final
class ScipyEvolution(Solver):
    """`scipy.optimize.differential_evolution`, settings by SciPy's names; it evaluates whole populations at once."""

    called: ClassVar[str] = "scipy-de"
    settings: ClassVar[tuple[Setting, ...]] = (
        whole("popsize"),
        whole("maxiter"),
        number("tol"),
        number("mutation", 0.0, 2.0),
        share("recombination"),
        word("strategy", STRATEGIES),
        switch("polish"),
    )
    title = "SciPy's differential evolution"

    def __init__(self, name: str = called, **settings: Any) -> None:
        self.name, self._settings = name, settings

    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Search until the evaluator ends the run."""
        from scipy.optimize import Bounds, differential_evolution  # noqa: PLC0415 - half a second to import

        problem, rng = evaluator.problem, np.random.default_rng(seed)

        def costs(x: Array, /) -> Any:
            found = evaluator.cost(within(np.atleast_2d(x.T), problem))
            return found if x.ndim == 2 else found[0]

        for start in chain(problem.starts[:1], repeat(None)):
            differential_evolution(
                costs,
                Bounds(problem.lower, problem.upper),
                vectorized=True,
                updating="deferred",
                x0=start,
                seed=int(rng.integers(1, 2**31)),
                **self._settings,
            )
