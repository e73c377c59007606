"""Candidates anywhere: what every search has to beat."""

from typing import ClassVar, final

import numpy as np

from robolaser.algorithms.settings import Setting
from robolaser.benchmark.evaluator import Watch
from robolaser.benchmark.solvers.solver import Contestant

AT_ONCE = 100


@final
class RandomSearch(Contestant):
    """Uniform within the bounds."""

    called: ClassVar[str] = "random"
    settings: ClassVar[tuple[Setting, ...]] = ()
    title = "candidates anywhere: what every search has to beat"

    def __init__(self, name: str = called) -> None:
        self.name = name

    def search(self, watch: Watch, seed: int) -> None:
        """Ask until the watch ends it."""
        rng = np.random.default_rng(seed)
        while True:
            watch.cost(watch.question.anywhere(rng, AT_ONCE))
