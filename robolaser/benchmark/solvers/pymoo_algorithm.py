"""An algorithm of pymoo's kind, begun anew whenever it comes to an end."""

from collections.abc import Callable
from typing import Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.evaluator import Watch
from robolaser.benchmark.solvers.solver import Contestant
from robolaser.benchmark.solvers.within import within
from robolaser.errors import NothingAsked

IDLE_ROUNDS = 1000
"""Rounds without a candidate after which an algorithm is taken to go round in circles."""
COLLAPSED = 1e-9
"""Of the bounds' distance: candidates no further from each other are one. J, which changes with the square, is the
same there."""


@final
class PymooAlgorithm(Contestant):
    """Runs with what is left of the budget; where it ends or has collapsed to a point, it starts with another seed.

    The budget is its only termination, so k/T of the operators is the share of it that is used up.

    Args:
        name: As asked for.
        title: What it is.
        make: Makes the algorithm, a new one for each start.
    """

    def __init__(self, name: str, title: str, make: Callable[[], Any]) -> None:
        self.name, self.title, self._make = name, title, make

    def search(self, watch: Watch, seed: int) -> None:
        """Search until the watch ends it.

        Raises:
            NothingAsked: It goes on and on without a candidate.
        """
        from robolaser.algorithms.seeding import seeded  # noqa: PLC0415 - pymoo takes a second to import
        from robolaser.problems.bounded import Bounded  # noqa: PLC0415

        question, rng, idle = watch.question, np.random.default_rng(seed), 0
        with seeded(seed):
            while idle < IDLE_ROUNDS:
                asked = _Asked(watch)
                algorithm, problem = self._make(), Bounded(asked, question.lower, question.upper)
                algorithm.setup(problem, termination=("n_eval", watch.left), seed=seed, verbose=False)
                idle += 1  # it may end before it begins
                while algorithm.has_next() and not asked.collapsed and idle < IDLE_ROUNDS:
                    before = watch.evaluations
                    algorithm.next()
                    idle = idle + 1 if watch.evaluations == before else 0
                seed = int(rng.integers(1, 2**31))
        raise NothingAsked(idle)


@final
class _Asked:
    """Asks the watch, and notices when candidates differ no more."""

    def __init__(self, watch: Watch) -> None:
        self._watch = watch
        question = watch.question
        self._width = question.upper - question.lower
        self._enough = 20 + 2 * question.dimension
        self._same = 0
        self._as: Array = np.full(question.dimension, np.nan)

    def __call__(self, x: Array) -> Array:
        if (np.abs(x - self._as) <= COLLAPSED * self._width).all():
            self._same += len(x)
        else:
            self._same, self._as = 0, x[-1].copy()
        return self._watch.cost(within(x, self._watch.question))

    @property
    def collapsed(self) -> bool:
        """Whether the last candidates, more than a simplex has corners, were all the same."""
        return self._same >= self._enough
