"""A trial on disk: data sets are made, diagnosed if they are not yet, and scored.

The truth is in a separate folder, under the SHA-256 that the trial states from the start.
"""

import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.arrays import Progress
from robolaser.bounded_reading import read_bytes, read_text
from robolaser.calibration.saved import DIAGNOSIS as DIAGNOSED
from robolaser.calibration.saved import read_result
from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.data.result_folder import Claim, json_text, make_folder, write_results, write_together
from robolaser.data.writing import FOLDER, texts_of
from robolaser.diagnosis import examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.errors import DataError, TrialError
from robolaser.robot.kinematics import Robot
from robolaser.trials.building import Ranges
from robolaser.trials.kinds import IN_IMAGES, USUAL, kinds_of
from robolaser.trials.making import make
from robolaser.trials.resampling import reference_of
from robolaser.trials.score import compile_score, outcome

DIAGNOSIS = "diagnosis/diagnosis.json"
TRUTH = "robolaser-truth/1"
SEAL = "seal.txt"  # of a trial: the SHA-256 of its truth, which has those of its data


@final
@dataclass(frozen=True)
class TrialPlan:
    """Which data sets a trial has."""

    count: int
    seed: int  # same seed, same trial
    kinds: Sequence[str] = ()  # in equal shares; none: those of `USUAL`, in theirs
    ranges: Ranges = field(default_factory=Ranges)  # of other random quantities


def new(
    folder: Path, truth: Path, sources: Sequence[Robot | Dataset], plan: TrialPlan, *, claim: Claim, progress: Progress
) -> list[str]:
    """Make blind data sets in a folder, and keep the truth about them in another.

    Args:
        folder: Of the data sets, whose names reveal nothing; these names are returned.
        truth: Of the truth.
        sources: Arms, or data sets to imitate; they take turns.
        plan: Which data sets.
        claim: Of the folder.
        progress: Called with the current step and its finished share.

    Raises:
        UsageError: Not one of `KINDS`, nor a fault.
        TrialError: A data set with another sensor, without joint angles, or without a placed target.
        DependencyMissing: MuJoCo moves some of the worlds, and is not installed.
        OutputError: Writing fails.
    """
    kinds = dict.fromkeys(kinds_of(plan.kinds), 1.0)
    if not kinds:
        tracked = any(isinstance(source, Dataset) and source.kind == "point" for source in sources)
        kinds = {kind: share for kind, share in USUAL.items() if not (tracked and kind in IN_IMAGES)}
    names = [f"world-{i:03d}" for i in range(plan.count)]
    earlier = claim([SEAL, *(f"{name}/{file}" for name in names for file in (*FOLDER, DIAGNOSIS))])
    rng = np.random.default_rng(plan.seed)
    patterns = [reference_of(source, seed=plan.seed) if isinstance(source, Dataset) else source for source in sources]
    dealt = deal(kinds, plan.count, rng)
    seeds = rng.integers(1 << 40, size=plan.count).tolist()
    truths, files = {}, {}
    for i, (name, kind, seed) in enumerate(zip(names, dealt, seeds, strict=True)):
        progress("making worlds", i / plan.count)
        source = patterns[i % len(patterns)]
        world = make(source, kind, seed=seed, name=name, ranges=plan.ranges)
        truths[name], files[name] = world.truth, texts_of(world.dataset)
    seal = keep_truth(truth, truths, files, rng)
    written = {f"{name}/{file}": text for name in names for file, text in files[name].items()}
    diagnoses = {f"{name}/{DIAGNOSIS}": None for name in names}  # of the worlds that were here before
    write_results(folder, {**dict.fromkeys(earlier), **written, **diagnoses, SEAL: seal})
    return names


def deal(kinds: Mapping[str, float], count: int, rng: np.random.Generator) -> list[str]:
    """Kinds in the requested shares, rounded to whole numbers, in any order."""
    shares = np.array(list(kinds.values())) / sum(kinds.values()) * count
    whole = np.floor(shares).astype(int)
    for i in np.argsort(whole - shares, kind="stable")[: count - int(whole.sum())]:
        whole[i] += 1
    return [str(kind) for kind in rng.permutation(np.repeat(list(kinds), whole))]


def diagnosis_files(folder: Path, names: Iterable[str], output: Path) -> dict[str, Path]:
    """Paths of the diagnoses of a trial's data sets: existing ones, or in `output`."""
    return {name: (folder if (folder / name / DIAGNOSIS).exists() else output) / name / DIAGNOSIS for name in names}


def diagnose_missing(folder: Path, files: Mapping[str, Path], *, seed: int, pool: Executor, progress: Progress) -> None:
    """Diagnose the data sets of a trial that have none of the files yet, which are named by data set.

    Raises:
        TrialError: One cannot be made.
    """
    missing = [name for name, path in files.items() if not path.exists()]
    futures = {pool.submit(_diagnosed, load(folder / name), seed): name for name in missing}
    for i, future in enumerate(as_completed(futures)):
        progress("diagnosing", i / len(missing))
        path = files[futures[future]]
        try:
            text = future.result()
        except Exception as error:
            raise TrialError(f"{futures[future]} could not be diagnosed: {error}") from error
        write_results(path.parent, {path.name: text})


def score(truths: Mapping[str, Mapping[str, Any]], files: Mapping[str, Path]) -> dict[str, Any]:
    """The contents of score.json for the diagnoses of a trial; truths and files are by data set.

    Raises:
        TrialError: A file is no diagnosis.
    """
    outcomes = {}
    for name, path in files.items():
        try:
            outcomes[name] = outcome(truths[name], read_diagnosis(path))
        except (TypeError, KeyError, ValueError, AttributeError) as error:
            raise _no_diagnosis(path, f"{type(error).__name__}: {error}") from None
    return compile_score(outcomes)


def read_diagnosis(path: Path) -> dict[str, Any]:
    """The contents of a diagnosis.json; a `TrialError` if it is none."""
    try:
        contents = read_result(path, DIAGNOSED)[0]
    except DataError as error:
        raise _no_diagnosis(path, str(error).rstrip(".")) from None
    if missing := [key for key in ("verdict", "gap_mm", "where") if key not in contents]:
        raise _no_diagnosis(path, f"it lacks {', '.join(missing)}")
    return contents


def _diagnosed(dataset: Dataset, seed: int) -> str:
    return json_text(diagnosis_json(examine(dataset, seed=seed)))


def _no_diagnosis(path: Path, why: str) -> TrialError:
    return TrialError(
        f"{path} is not a diagnosis in the format {DIAGNOSED}: {why}. Delete it to have the data set diagnosed again."
    )


def truth_beside(folder: Path) -> Path:
    """Default folder of a trial's truth: next to the trial, which may be given away."""
    named = folder if folder.name not in ("", "..") else folder.resolve()
    return named.with_name(f"{named.name}.truth")


def keep_truth(
    folder: Path,
    truths: Mapping[str, Mapping[str, Any]],
    files: Mapping[str, Mapping[str, str | None]],
    rng: np.random.Generator,
) -> str:
    """Write the truth about data sets and the hashes of their files; the text of the trial's seal.

    A truth is named by its own hash: it never takes the place of another one. Without the salt that `rng` draws, a
    guess could be checked against the hash.

    Raises:
        OutputError: Writing fails.
    """
    hashes = {
        name: _hash_of({file: text.encode() for file, text in texts.items() if text is not None})
        for name, texts in files.items()
    }
    worlds = {name: {"truth": truth, "data": hashes[name]} for name, truth in truths.items()}
    text = json.dumps({"format": TRUTH, "salt": rng.bytes(16).hex(), "worlds": worlds}, sort_keys=True).encode()
    number = hashlib.sha256(text).hexdigest()
    make_folder(folder)
    write_together(folder, {f"{number}.json": text}, mode=0o600)
    return f"sha256 {number}\n"


def unseal(folder: Path, truth: Path) -> dict[str, dict[str, Any]]:
    """The truth about each data set of a trial, from the folders of both.

    Raises:
        TrialError: There is no trial, its truth is missing, or truth or data were changed.
    """
    if not (folder / SEAL).is_file():
        raise TrialError(
            f"{folder} has no {SEAL}, so it is not a blind trial. Make one with `robolaser challenge new`."
        )
    number = re.fullmatch(r"sha256 ([0-9a-f]{64})", read_text(folder / SEAL).strip())
    if number is None:
        raise _changed(folder / SEAL, "does not state a SHA-256")
    path = truth / f"{number[1]}.json"
    try:
        text = read_bytes(path)
    except DataError as error:
        raise TrialError(f"{error} The maker of the trial has its truth: --truth DIR.") from None
    if hashlib.sha256(text).hexdigest() != number[1]:
        raise _changed(path, f"does not match the hash in {folder / SEAL}")
    worlds = json.loads(text)["worlds"]
    for name, world in worlds.items():
        there = {file: read_bytes(folder / name / file) for file in FOLDER if (folder / name / file).is_file()}
        if _hash_of(there) != world["data"]:
            raise _changed(folder / name, "holds other data than were made")
    return {name: world["truth"] for name, world in worlds.items()}


def _hash_of(files: Mapping[str, bytes]) -> str:
    """SHA-256 of a data set's files with their names."""
    total = hashlib.sha256()
    for name in filter(files.__contains__, FOLDER):
        total.update(f"{name} {hashlib.sha256(files[name]).hexdigest()}\n".encode())
    return total.hexdigest()


def _changed(path: Path, wrong: str) -> TrialError:
    return TrialError(
        f"{path} {wrong}: something was changed after the trial was made. Its score would mean nothing; make the trial"
        " again."
    )
