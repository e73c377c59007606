"""The global search: one problem, one algorithm, one budget, one seed; it can be stopped and resumed."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Ints, Progress
from robolaser.calibration.search_state import load_state, save_state

CHECKPOINT = "search.npz"
COURSE = ("evaluations", "best", "x")
INSTEAD_OF_0 = 2**31 - 1  # pycma seeds itself from the clock where the seed is 0
ON_THE_WAY = 10  # earlier best candidates that are returned
SECONDS_BETWEEN_CHECKPOINTS = 2.0  # an interrupted run loses no more than that


@final
@dataclass(frozen=True)
class History:
    """The course of a search, one entry a generation (g)."""

    names: tuple[str, ...]  # the problem's variables
    evaluations: Ints  # candidates evaluated so far, (g,)
    best: Array  # best cost so far, (g,) [m²]
    x: Array  # best candidate so far, (g, d)


@final
@dataclass(frozen=True)
class Found:
    """The candidates at the end of a search."""

    # The best, those that were the best in earlier generations, then the last members, (k, d). The last members
    # resemble each other; earlier ones lie elsewhere.
    candidates: Array
    history: History  # the course of the search
    evaluations: int  # candidates evaluated


def search(
    problem: Any,
    algorithm: Any,
    *,
    generations: int,
    seed: int,
    state: Path | None = None,
    resume: bool = False,
    fingerprint: str = "",
    progress: Progress | None = None,
) -> Found:
    """Run an algorithm for a number of generations, or until it stops by itself.

    Args:
        problem: A pymoo problem with `names`.
        algorithm: A pymoo algorithm.
        generations: The last generation T.
        seed: Makes the run repeatable to the last bit.
        state: A folder for checkpoints; only `RCGA` can leave any.
        resume: Continue from the checkpoint in `state`, if there is one.
        fingerprint: Digest of the data and the plan; the checkpoint of another run is refused.
        progress: Called after every generation.

    Raises:
        AlgorithmError: The checkpoint belongs to another run or is damaged.
    """
    from pymoo.termination import get_termination  # noqa: PLC0415 - pymoo takes a second to import

    from robolaser.algorithms.rcga import RCGA  # noqa: PLC0415

    termination = get_termination("n_gen", generations)
    course = _Course(problem.names)
    keeps = state if isinstance(algorithm, RCGA) else None
    algorithm.setup(problem, termination=termination, seed=seed or INSTEAD_OF_0, verbose=False)
    if keeps is not None and resume and (keeps / CHECKPOINT).exists():
        course.read(load_state(algorithm, keeps / CHECKPOINT, fingerprint, COURSE))
    saved = time.monotonic()
    while algorithm.has_next():
        algorithm.next()
        course.add(*_generation(algorithm), int(algorithm.evaluator.n_eval))
        if progress is not None:
            progress("searching", min(1.0, len(course.best) / generations))
        if keeps is not None and time.monotonic() - saved > SECONDS_BETWEEN_CHECKPOINTS:
            save_state(algorithm, course.arrays, keeps / CHECKPOINT, fingerprint)
            saved = time.monotonic()
    X, F = _generation(algorithm)
    last = X[np.argsort(F, kind="stable")]
    on_the_way = course.x[:: -max(1, len(course.x) // ON_THE_WAY)]
    return Found(np.vstack([*on_the_way, last]), course.history, int(algorithm.evaluator.n_eval))


def _generation(algorithm: Any) -> tuple[Array, Array]:
    """The members of any algorithm and their costs, (n, d) and (n,)."""
    from robolaser.algorithms.array_based import ArrayBased  # noqa: PLC0415 - pymoo takes a second to import

    if isinstance(algorithm, ArrayBased):
        return algorithm.arrays.X, algorithm.arrays.F
    X, F = algorithm.pop.get("X", "F")
    return np.asarray(X, np.float64), np.asarray(F[:, 0], np.float64)


class _Course:
    """Collects the history of a search."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names
        self.evaluations: list[int] = []
        self.best: list[float] = []
        self.x: list[Array] = []

    def add(self, X: Array, F: Array, evaluations: int) -> None:
        i = int(np.argmin(F))
        if np.isnan(F[i]):
            i = int(np.argmin(np.where(np.isnan(F), np.inf, F)))
        better = not self.best or F[i] < self.best[-1]
        self.best.append(float(F[i]) if better else self.best[-1])
        self.x.append(X[i].copy() if better else self.x[-1])
        self.evaluations.append(evaluations)

    @property
    def history(self) -> History:
        return History(self.names, np.array(self.evaluations), np.array(self.best), np.array(self.x))

    @property
    def arrays(self) -> dict[str, Any]:
        return {"evaluations": self.evaluations, "best": self.best, "x": self.x}

    def read(self, arrays: dict[str, Any]) -> None:
        self.evaluations = [int(n) for n in arrays["evaluations"]]
        self.best = [float(b) for b in arrays["best"]]
        self.x = list(arrays["x"])
