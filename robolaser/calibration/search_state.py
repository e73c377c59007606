"""The state of a stopped search in a file: numbers, no code; a resumed search goes on as if it had never stopped."""

import io
import json
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from robolaser.bounded_reading import ARRAY_BYTES, opened
from robolaser.data.array_damage import DAMAGE
from robolaser.data.atomic_write import write_bytes
from robolaser.errors import AlgorithmError, DataError

FORMAT = "robolaser-checkpoint/3"


def save_state(algorithm: Any, course: Mapping[str, Any], path: Path, fingerprint: str) -> None:
    """Save a run of `RCGA` between two generations, and its course so far, in the place of an earlier state.

    Raises:
        OutputError: The file cannot be written; an earlier one is unharmed.
    """
    header = {
        "format": FORMAT,
        "fingerprint": fingerprint,
        "random_state": algorithm.random_state.bit_generator.state,
        "generation": algorithm.n_iter,
        "evaluations": algorithm.evaluator.n_eval,
    }
    X, F = algorithm.pop.get("X", "F")
    write_arrays(path, {"header": np.array(json.dumps(header)), "X": X, "F": F, **course})


def load_state(algorithm: Any, path: Path, fingerprint: str, course: Sequence[str]) -> dict[str, Any]:
    """Put an algorithm that was set up as that of the run into the state that was saved; returns the run's course.

    Raises:
        AlgorithmError: The file is missing or damaged, or belongs to another run.
    """
    from pymoo.core.population import Population  # noqa: PLC0415 - pymoo takes a second to import

    arrays = read_arrays(path, ("header", "X", "F", *course))
    try:
        header = json.loads(str(arrays["header"]))
        if header["format"] != FORMAT:
            raise _unreadable(path, f"its format is {header['format']!r}, this program reads {FORMAT!r}")
        if header["fingerprint"] != fingerprint:
            raise AlgorithmError(
                f"{path} belongs to another run. Resume with the data and options that the run was started with, or"
                " delete the checkpoint to start over."
            )
        algorithm._initialize()
        algorithm.random_state.bit_generator.state = header["random_state"]
        algorithm.n_iter, algorithm.evaluator.n_eval = header["generation"], header["evaluations"]
        algorithm.pop = algorithm.evaluator.eval(
            algorithm.problem, Population.new(X=arrays["X"], F=arrays["F"]), skip_already_evaluated=True
        )
    except DAMAGE as error:
        raise _unreadable(path, f"it is not a checkpoint ({error})") from None
    algorithm.is_initialized = True
    algorithm._set_optimum()
    return {name: arrays[name] for name in course}


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


def _unreadable(path: Path, reason: str) -> AlgorithmError:
    return AlgorithmError(f"{path} is no whole state of a search: {reason}. Delete it to start the run over.")
