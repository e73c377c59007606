"""Our own default: what `robolaser calibrate` does where nobody asks for another search."""

from typing import ClassVar, final

import numpy as np

from robolaser.algorithms.registry import SCREENING
from robolaser.algorithms.settings import Setting
from robolaser.benchmark.evaluator import Watch
from robolaser.benchmark.problem import Question
from robolaser.benchmark.solvers.solver import Contestant
from robolaser.estimation.multistart import SoFar, multistart


@final
class Screening(Contestant):
    """`robolaser.estimation.multistart`, which ends when descents agree; it is told of after each round, with J of all rows.

    `calibrate` lets it go downhill from the nominal values too. Here it does without: nobody else knows them.
    """

    called: ClassVar[str] = SCREENING
    settings: ClassVar[tuple[Setting, ...]] = ()
    title = "robolaser's default: the best of random candidates sent downhill until they agree"

    def __init__(self, name: str = called) -> None:
        self.name = name

    def refuses(self, question: Question) -> str | None:
        """What is no calibration."""
        return None if question.model is not None else "it knows calibrations only, by their closed forms"

    def search(self, watch: Watch, seed: int) -> None:
        """Search until descents agree."""
        model = watch.question.model
        if model is None:
            raise TypeError(f"{watch.question.name} is no calibration")
        told = 0

        def note(evaluations: int, cost: float) -> None:
            nonlocal told
            watch.saw(evaluations - told + 1, cost)  # and one on all rows, for J
            told = evaluations

        def look(so_far: SoFar) -> None:
            note(so_far.evaluations, float(model.cost(so_far.x[None])[0]))

        nowhere = np.empty((0, len(model.parameters)))
        found = multistart(model, seed=seed, starts=nowhere, progress=look)
        note(found.evaluations, found.cost)
