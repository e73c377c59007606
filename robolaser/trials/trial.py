"""A trial on disk: data sets made and sealed, diagnosed where no diagnosis is there yet, and scored."""

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np

from robolaser.arrays import Progress
from robolaser.bounded_reading import read_bytes, read_json
from robolaser.data.dataset import Dataset
from robolaser.data.writing import FOLDER, texts_of
from robolaser.errors import DataError, TrialError
from robolaser.robot.kinematics import Robot
from robolaser.trials.building import Ranges
from robolaser.trials.diagnosing import diagnose_all
from robolaser.trials.kinds import IN_IMAGES, USUAL, kinds_of
from robolaser.trials.making import make
from robolaser.trials.outcome import outcome
from robolaser.trials.resampling import reference_of
from robolaser.trials.score import compile_score
from robolaser.trials.sealed_truth import DIAGNOSIS, SEAL, TRUTH, data_hash, seal, unseal

_FORMAT = "robolaser-diagnosis/1"
_NEEDED = ("verdict", "gap_mm", "where", "effects")

"""Is told what is going on, and how far it is."""


def _nothing(what: str, share: float) -> None:
    return None


def new(
    folder: Path,
    sources: Sequence[Robot | Dataset],
    *,
    count: int,
    seed: int,
    kinds: Mapping[str, float] | None = None,
    ranges: Ranges | None = None,
    tracked: bool = False,
    key: Path,
    claim: Callable[[Iterable[str]], None],
    keeping: Callable[[], AbstractContextManager[object]],
    tell: Progress = _nothing,
) -> list[str]:
    """Make blind data sets in a folder, and seal the truth about them.

    Args:
        folder: Each data set is put into it under a name that says nothing.
        sources: Arms, or data sets to imitate; they take turns.
        count: How many.
        seed: Same seed, same trial.
        kinds: How often each kind of world comes, in any unit. Absent: `USUAL`.
        ranges: What else is left to chance.
        tracked: Whether a tracker sees every arm.
        key: File for the key of the seals.
        claim: Is told the names of all files that will be written to the folder.
        keeping: Within which the key is written.
        tell: Progress.

    Returns:
        The names of the data sets.

    Raises:
        UsageError: Not one of `KINDS`, nor a fault.
        TrialError: A data set with another sensor, without joint angles, or without a placed target.
        DependencyMissing: MuJoCo moves some of the worlds, and is not installed.
        OutputError: The disk or the rights say no.
    """
    if kinds is None:
        tracked = tracked or any(isinstance(source, Dataset) and source.kind == "point" for source in sources)
        kinds = {kind: share for kind, share in USUAL.items() if not (tracked and kind in IN_IMAGES)}
    kinds_of(kinds)
    worlds = [f"world-{i:03d}" for i in range(count)]
    claim([TRUTH, *(f"{world}/{file}" for world in worlds for file in (*FOLDER, SEAL, DIAGNOSIS))])
    rng = np.random.default_rng(seed)
    patterns = [reference_of(source, seed=seed) if isinstance(source, Dataset) else source for source in sources]
    drawn = deal(kinds, count, rng)
    children = rng.integers(1 << 40, size=count)
    files: dict[str, dict[str, str | None]] = {}
    truths = {}
    for i, kind in enumerate(drawn):
        tell("making worlds", i / count)
        name = worlds[i]
        source = patterns[i % len(patterns)]
        world = make(source, kind, seed=int(children[i]), name=name, ranges=ranges, tracked=tracked)
        files[name] = texts_of(world.dataset)
        truths[name] = world.truth
    with keeping():
        seal(folder, files, truths, rng, key)
    return list(truths)


def deal(kinds: Mapping[str, float], count: int, rng: np.random.Generator) -> list[str]:
    """Kinds in the shares that are asked for, as nearly as whole numbers go, in any order."""
    shares = np.array(list(kinds.values())) / sum(kinds.values()) * count
    whole = np.floor(shares).astype(int)
    for i in np.argsort(whole - shares, kind="stable")[: count - int(whole.sum())]:
        whole[i] += 1
    return [str(kind) for kind in rng.permutation(np.repeat(list(kinds), whole))]


def score(
    folder: Path,
    output: Path,
    *,
    seed: int,
    executor: Executor | None = None,
    key: Path,
    claim: Callable[[Iterable[str]], None],
    tell: Progress = _nothing,
) -> dict[str, Any]:
    """Open the seals of a trial and score the diagnoses in it.

    A data set without `diagnosis/diagnosis.json` is diagnosed first, and the result is written to its name in `output`.

    Args:
        folder: Of the trial.
        output: Where diagnoses are written; the trial's folder may be it.
        seed: Of the diagnoses that are still to be made.
        executor: Where they are made; None: in this process, one after another.
        key: The trial's key.
        claim: Is told the names of all files that will be written to the output.
        tell: Progress.

    Returns:
        What score.json holds.

    Raises:
        TrialError: The truth is not there, or was touched; a file is no diagnosis, or one cannot be made.
    """
    truths = unseal(folder, key)
    paths = {name: (folder if (folder / name / DIAGNOSIS).exists() else output) / name / DIAGNOSIS for name in truths}
    missing = [name for name, path in paths.items() if not path.exists()]
    claim(f"{name}/{DIAGNOSIS}" for name in missing)
    worlds = {folder / name: paths[name] for name in missing}
    for done in diagnose_all(worlds, seed=seed, executor=executor):
        tell("diagnosing", done / len(missing))
    outcomes, hashes = {}, {}
    for name, truth in truths.items():
        path = paths[name]
        try:
            outcomes[name] = outcome(truth, read_diagnosis(path))
        except (TypeError, KeyError, ValueError, AttributeError) as error:
            raise _no_diagnosis(path, f"{type(error).__name__}: {error}") from None
        hashes[name] = {"data": data_hash(folder / name), "diagnosis": hashlib.sha256(read_bytes(path)).hexdigest()}
    return compile_score(outcomes) | {"sha256": hashes}


def read_diagnosis(path: Path) -> dict[str, Any]:
    """A diagnosis.json.

    Raises:
        TrialError: It is none.
    """
    try:
        said = read_json(path)
    except DataError as error:
        raise _no_diagnosis(path, str(error).rstrip(".")) from None
    if not isinstance(said, dict) or said.get("format") != _FORMAT:
        raise _no_diagnosis(path, "it does not say that it is one")
    missing = [key for key in _NEEDED if key not in said]
    if missing:
        raise _no_diagnosis(path, f"it lacks {', '.join(missing)}")
    return said


def _no_diagnosis(path: Path, why: str) -> TrialError:
    return TrialError(
        f"{path} is not a diagnosis in the format robolaser-diagnosis/1: {why}. "
        "Delete it to have the data set diagnosed again."
    )
