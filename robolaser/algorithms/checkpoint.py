"""Checkpoints of the genetic algorithm: a resumed run goes on as if it had never stopped."""

import io
import json
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pymoo.core.termination import Termination
from pymoo.core.variable import get
from pymoo.util.sliding_window import SlidingWindow

from robolaser.algorithms.population import PopulationArrays
from robolaser.algorithms.rcga import RCGA
from robolaser.bounded_reading import ARRAY_BYTES, opened
from robolaser.data.array_damage import DAMAGE
from robolaser.data.atomic_write import write_bytes
from robolaser.errors import AlgorithmError, DataError

FORMAT = "robolaser-checkpoint/2"

_STORED = ("X", "F", "G", "H")

_STATE = ("perc", "force_termination", "best", "since", "data", "counter", "history")
"""State of terminations between generations, robolaser's and pymoo's."""


def save(algorithm: RCGA, path: Path | str, *, fingerprint: str = "") -> None:
    """Save a run between two generations: between calls of `next()`, or in a callback.

    The file is replaced atomically: at any moment it holds the last whole checkpoint. It does not contain the problem,
    callbacks, the archive or the history; of parts that are not the paper's (a repair, another crossover) only what
    they are, so that `load` can ask for them.

    Args:
        algorithm: The run.
        path: The file, .npz.
        fingerprint: Identifies the run, such as a hash of its data; `load` expects the same.

    Raises:
        AlgorithmError: It is no RCGA, or its first generation has not been evaluated yet.
        OutputError: The file cannot be written; an earlier one is unharmed.
    """
    if type(algorithm) is not RCGA:
        raise AlgorithmError(
            f"Checkpoints are RCGA's; this is {type(algorithm).__name__}. pymoo's own way is to store the whole object"
            " with dill."
        )
    if not algorithm.is_initialized:
        raise AlgorithmError("No checkpoint can be taken: the run has no evaluated generation yet. Call next() first.")
    arrays = algorithm.arrays
    born = arrays.columns["born"]
    header = {
        "format": FORMAT,
        "fingerprint": fingerprint,
        "settings": algorithm.settings,
        "parts": foreign_parts(algorithm),
        "seed": algorithm.seed,
        "random_state": algorithm.random_state.bit_generator.state,
        "generation": int(born.max()),
        "evaluations": algorithm.evaluator.n_eval,
        "seconds": time.time() - algorithm.start_time,
        "termination": [_state_of(node) for node in _nodes(algorithm.termination)],
    }
    empty = np.empty((len(arrays), 0))
    stored = {key: np.asarray(arrays.columns.get(key, empty), np.float64) for key in _STORED}
    text = np.array(json.dumps(header, default=_as_json))
    write_arrays(Path(path), {"header": text, "born": born, **stored})


def load(
    path: Path | str,
    problem: Any,
    *,
    algorithm: RCGA | None = None,
    termination: Any = None,
    fingerprint: str = "",
    **setup: Any,
) -> RCGA:
    """Resume a run: its next generation is the one it would have had, to the last bit.

    Args:
        path: The file that `save` wrote.
        problem: The problem of the run.
        algorithm: One made as that of the run was and not yet used; needed if it has other parts than the paper's.
        termination: That of the run, if it had another than its own; a different one goes on under new rules.
        fingerprint: As given to `save`.
        setup: More for pymoo's `setup`: callback, verbose, save_history, archive.

    Raises:
        AlgorithmError: The file is missing, damaged or no checkpoint, it belongs to another problem, or the run had a
            termination or other parts that are not given.
    """
    path = Path(path)
    header, arrays = _read(path)
    for what, found, expected in (
        ("its fingerprint", header["fingerprint"], fingerprint),
        ("the number of its variables", arrays["X"].shape[1], problem.n_var),
        ("the number of its objectives", arrays["F"].shape[1], problem.n_obj),
    ):
        if found != expected:
            raise _foreign(path, what, found, expected)

    if algorithm is None:
        algorithm = RCGA(**header["settings"])
    for slot, found, expected in _differing(header["parts"], foreign_parts(algorithm)):
        raise _foreign(path, f"its {slot}", found, expected)
    for name, value in header["settings"].items():
        if algorithm.settings.get(name) != value:
            raise _foreign(path, f"its {name}", value, algorithm.settings.get(name))
    if termination is not None:
        setup["termination"] = termination
    algorithm.setup(problem, seed=header["seed"], **setup)
    nodes = list(_nodes(algorithm.termination))
    kinds, saved_kinds = [type(node).__name__ for node in nodes], [kind for kind, _ in header["termination"]]
    if termination is None and kinds != saved_kinds:
        raise _foreign(path, "its termination", ", ".join(saved_kinds), ", ".join(kinds))
    if kinds == saved_kinds:
        for node, (_, state) in zip(nodes, header["termination"], strict=True):
            _restore(node, state)

    algorithm._initialize()
    algorithm.is_initialized = True
    algorithm.n_iter = header["generation"] + 1
    algorithm.start_time = time.time() - header["seconds"]
    algorithm.evaluator.n_eval = header["evaluations"]
    algorithm.random_state.bit_generator.state = header["random_state"]
    born = arrays.pop("born")
    algorithm.arrays = PopulationArrays.evaluated_as(arrays.pop("X"), arrays, born, frozenset())
    return algorithm


def foreign_parts(algorithm: RCGA) -> dict[str, str]:
    """Parts of an algorithm that its settings do not make, by slot: their class and what was set in it."""
    own, usual = _parts(algorithm), _parts(RCGA(**algorithm.settings))
    return {slot: part for slot, part in own.items() if part != usual[slot]}


def _parts(algorithm: RCGA) -> dict[str, str]:
    mating = algorithm.mating
    parts = {
        "mating": mating,
        "selection": mating.selection,
        "crossover": mating.crossover,
        "mutation": mating.mutation,
        "repair": mating.repair,
        "eliminate_duplicates": mating.eliminate_duplicates,
        "survival": algorithm.survival,
    }
    return {slot: _described(part) for slot, part in parts.items()}


def _described(part: Any) -> str:
    """The class of a part and its settings that are numbers or words: `SBX(eta=15, prob=0.9)`."""
    known = {name: get(value) for name, value in sorted(vars(part).items()) if name != "name"}
    stated = {name: value for name, value in known.items() if isinstance(value, (bool, int, float, str))}
    return f"{type(part).__qualname__}({', '.join(f'{name}={value!r}' for name, value in stated.items())})"


def _differing(saved: dict[str, str], given: dict[str, str]) -> Iterator[tuple[str, str, str]]:
    for slot in sorted({*saved, *given}):
        if saved.get(slot) != given.get(slot):
            yield slot, saved.get(slot, "the paper's"), given.get(slot, "the paper's")


def _nodes(termination: Termination) -> Iterator[Termination]:
    """Walk through a termination and all those it consists of, in the order in which they were put together."""
    yield termination
    for value in vars(termination).values():
        for part in value if isinstance(value, (list, tuple)) else (value,):
            if isinstance(part, Termination):
                yield from _nodes(part)


def _state_of(node: Termination) -> tuple[str, dict[str, Any]]:
    state = {name: value for name, value in vars(node).items() if name in _STATE}
    return type(node).__name__, state


def _as_json(value: Any) -> Any:
    return {"array": value.tolist()} if isinstance(value, np.ndarray) else value.item()


def _restore(node: Termination, state: dict[str, Any]) -> None:
    for name, value in state.items():
        window = getattr(node, name)
        if isinstance(window, SlidingWindow):
            window[:] = value
        else:
            setattr(node, name, np.array(value["array"]) if isinstance(value, dict) else value)


def write_arrays(path: Path, arrays: Mapping[str, Any]) -> None:
    """Write arrays by name as a file of NumPy's, whole or not at all.

    Raises:
        OutputError: The disk or the rights say no.
    """
    file = io.BytesIO()
    np.savez(file, allow_pickle=False, **arrays)
    write_bytes(path, file.getvalue())


def read_arrays(path: Path, names: Sequence[str]) -> dict[str, Any]:
    """Read arrays by name.

    Raises:
        AlgorithmError: The file is missing, damaged, without one of them, or becomes larger than any search's state.
    """
    try:
        with (
            warnings.catch_warnings(action="ignore"),  # of headers that an old Python wrote
            opened(path, ARRAY_BYTES) as stream,
            np.load(stream, allow_pickle=False) as file,
        ):
            if sum(entry.file_size for entry in file.zip.infolist()) > ARRAY_BYTES:
                raise _unreadable(path, f"it would become more than {ARRAY_BYTES} bytes")
            return {name: file[name] for name in names}
    except DataError as error:
        raise _unreadable(path, str(error).rstrip(".")) from None
    except DAMAGE as error:
        raise _unreadable(path, f"it is truncated or damaged ({error})") from None


def _read(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    arrays = read_arrays(path, ("header", *_STORED, "born"))
    try:
        header = json.loads(str(arrays.pop("header")))
        found = header["format"]
    except DAMAGE as error:
        raise _unreadable(path, f"it is not a checkpoint ({error})") from None
    if found != FORMAT:
        raise _unreadable(path, f"its format is {found!r}, this program reads {FORMAT!r}")
    return header, arrays


def _unreadable(path: Path, reason: str) -> AlgorithmError:
    return AlgorithmError(f"{path} is no whole state of a search: {reason}. Delete it to start the run over.")


def _foreign(path: Path, what: str, found: object, expected: object) -> AlgorithmError:
    return AlgorithmError(
        f"{path} belongs to another run: {what} is {found}, here it is {expected}."
        " Resume with the data and options that the run was started with (other operators than the paper's by"
        " `algorithm`), or delete the checkpoint to start over."
    )
