"""SciPy's differential evolution, begun anew whenever it comes to an end."""

from typing import Any, ClassVar, final

import numpy as np

from robolaser.algorithms.settings import Setting, number, share, switch, whole, word
from robolaser.arrays import Array
from robolaser.benchmark.evaluator import Watch
from robolaser.benchmark.solvers.solver import Contestant
from robolaser.benchmark.solvers.within import within

STRATEGIES = tuple(
    f"{parents}1{crossover}"
    for parents in ("best", "rand", "currenttobest", "randtobest")
    for crossover in ("bin", "exp")
)


@final
class ScipyEvolution(Contestant):
    """`scipy.optimize.differential_evolution`, whole populations at once else.

    Args:
        name: As asked for.
        settings: Its own, by SciPy's names.
    """

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

    def search(self, watch: Watch, seed: int) -> None:
        """Search until the watch ends it."""
        from scipy.optimize import Bounds, differential_evolution  # noqa: PLC0415 - half a second to import

        question, rng = watch.question, np.random.default_rng(seed)

        def costs(x: Array, /) -> Any:
            found = watch.cost(within(np.atleast_2d(x.T), question))
            return found if x.ndim == 2 else found[0]

        while True:
            differential_evolution(
                costs,
                Bounds(question.lower, question.upper),
                vectorized=True,
                updating="deferred",
                seed=int(rng.integers(1, 2**31)),
                **self._settings,
            )
