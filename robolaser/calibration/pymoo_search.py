"""The global search: one problem, one algorithm, one budget, one seed.

Its state is a file of numbers without code, from which a stopped search continues exactly.
"""

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Ints, Progress
from robolaser.bounded_reading import read_text
from robolaser.data.result_folder import write_text
from robolaser.errors import AlgorithmError

CHECKPOINT = "search.json"
FORMAT = "robolaser-checkpoint/4"
COURSE = ("evaluations", "best", "x")  # of `History`
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
) -> tuple[Array, History]:
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

    Returns:
        The best candidate, the best of earlier generations, then the last members, (k, d): these resemble each
        other, earlier ones differ. And the course of the search.

    Raises:
        AlgorithmError: The checkpoint belongs to another run or is damaged.
    """
    from pymoo.termination import get_termination  # noqa: PLC0415 - pymoo takes a second to import

    from robolaser.algorithms.rcga import RCGA  # noqa: PLC0415

    termination = get_termination("n_gen", generations)
    course: dict[str, list[Any]] = {name: [] for name in COURSE}
    keeps = state if isinstance(algorithm, RCGA) else None
    algorithm.setup(problem, termination=termination, seed=seed or INSTEAD_OF_0, verbose=False)
    if keeps is not None and resume and (keeps / CHECKPOINT).exists():
        course = load_state(algorithm, keeps / CHECKPOINT, fingerprint)
    saved = time.monotonic()
    while algorithm.has_next():
        algorithm.next()
        _extend(course, *_generation(algorithm), int(algorithm.evaluator.n_eval))
        if progress is not None:
            progress("searching", min(1.0, len(course["best"]) / generations))
        if keeps is not None and time.monotonic() - saved > SECONDS_BETWEEN_CHECKPOINTS:
            save_state(algorithm, course, keeps / CHECKPOINT, fingerprint)
            saved = time.monotonic()
    X, F = _generation(algorithm)
    last = X[np.argsort(F, kind="stable")]
    on_the_way = course["x"][:: -max(1, len(course["x"]) // ON_THE_WAY)]
    return np.vstack([*on_the_way, last]), History(problem.names, *(np.array(course[name]) for name in COURSE))


def _generation(algorithm: Any) -> tuple[Array, Array]:
    """The members of any algorithm and their costs, (n, d) and (n,)."""
    from robolaser.algorithms.rcga import RCGA  # noqa: PLC0415 - pymoo takes a second to import

    if isinstance(algorithm, RCGA):
        return algorithm.arrays
    X, F = algorithm.pop.get("X", "F")
    return np.asarray(X, np.float64), np.asarray(F[:, 0], np.float64)


def _extend(course: Mapping[str, list[Any]], X: Array, F: Array, evaluations: int) -> None:
    """Add a generation to the course of a search."""
    i = int(np.argmin(np.where(np.isnan(F), np.inf, F)))
    better = not course["best"] or F[i] < course["best"][-1]
    course["evaluations"].append(evaluations)
    course["best"].append(float(F[i]) if better else course["best"][-1])
    course["x"].append(X[i].copy() if better else course["x"][-1])


def save_state(algorithm: Any, course: Mapping[str, Any], path: Path, fingerprint: str) -> None:
    """Save a run of `RCGA` between two generations, and its course so far; replaces an earlier state.

    Raises:
        OutputError: The file cannot be written; an earlier one is unchanged.
    """
    X, F = algorithm.arrays
    state = {
        "format": FORMAT,
        "fingerprint": fingerprint,
        "random_state": algorithm.random_state.bit_generator.state,
        "generation": algorithm.n_iter,
        "evaluations": algorithm.evaluator.n_eval,
        "X": X.tolist(),
        "F": F.tolist(),
        "course": {name: np.array(each).tolist() for name, each in course.items()},
    }
    write_text(path, json.dumps(state))


def load_state(algorithm: Any, path: Path, fingerprint: str) -> dict[str, list[Any]]:
    """Restore the saved state of an algorithm with the settings of the run; returns the run's course.

    Raises:
        AlgorithmError: The file is missing or damaged, or belongs to another run.
    """
    try:
        state = json.loads(read_text(path))  # with NaN
        if state["format"] != FORMAT:
            raise _unreadable(path, f"its format is {state['format']!r}, this program reads {FORMAT!r}")
        if state["fingerprint"] != fingerprint:
            raise AlgorithmError(
                f"{path} belongs to another run. Resume with the data and options that the run was started with, or"
                " delete the checkpoint to start over."
            )
        algorithm._initialize()
        algorithm.random_state.bit_generator.state = state["random_state"]
        algorithm.n_iter, algorithm.evaluator.n_eval = state["generation"], state["evaluations"]
        algorithm.arrays = np.array(state["X"], np.float64), np.array(state["F"], np.float64)
        course = {name: list(state["course"][name]) for name in COURSE}
    except AlgorithmError:
        raise
    except Exception as error:  # any exception that a damaged or foreign file can cause
        raise _unreadable(path, f"it is not a checkpoint ({str(error).rstrip('.')})") from None
    algorithm.is_initialized = True
    algorithm._set_optimum()
    return course


def _unreadable(path: Path, reason: str) -> AlgorithmError:
    return AlgorithmError(f"{path} is no whole state of a search: {reason}. Delete it to start the run over.")
