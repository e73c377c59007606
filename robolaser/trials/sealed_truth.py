"""The truth about a trial: in a folder of its own, under the SHA-256 that the trial states from the start."""

import hashlib
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from robolaser.bounded_reading import read_bytes, read_text
from robolaser.data.result_folder import make_folder, write_together
from robolaser.data.writing import FOLDER
from robolaser.errors import DataError, TrialError

FORMAT = "robolaser-truth/1"
SEAL = "seal.txt"  # of a trial: the SHA-256 of its truth, which has those of its data


def truth_beside(folder: Path) -> Path:
    """Where the truth of a trial is kept unless another folder is named: beside the trial, which may be given away."""
    named = folder if folder.name not in ("", "..") else folder.resolve()
    return named.with_name(f"{named.name}.truth")


def keep_truth(
    folder: Path,
    truths: Mapping[str, Mapping[str, Any]],
    files: Mapping[str, Mapping[str, str | None]],
    rng: np.random.Generator,
) -> str:
    """Write the truth about data sets and the hashes of their files; the text of the trial's seal.

    A truth is named by its own hash: it never takes the place of another one.

    Args:
        folder: Of the truth.
        truths: By data set.
        files: What the files of each data set hold, by its name and theirs.
        rng: Where the salt comes from, without which a guess could be checked against the hash.

    Raises:
        OutputError: The disk or the rights say no.
    """
    hashes = {
        name: _hash_of({file: text.encode() for file, text in texts.items() if text is not None})
        for name, texts in files.items()
    }
    worlds = {name: {"truth": truth, "data": hashes[name]} for name, truth in truths.items()}
    text = json.dumps({"format": FORMAT, "salt": rng.bytes(16).hex(), "worlds": worlds}, sort_keys=True).encode()
    number = hashlib.sha256(text).hexdigest()
    make_folder(folder)
    write_together(folder, {f"{number}.json": text}, mode=0o600)
    return f"sha256 {number}\n"


def unseal(folder: Path, truth: Path) -> dict[str, dict[str, Any]]:
    """The truth about each data set of a trial, of its folder and that of its truth.

    Raises:
        TrialError: There is no trial, its truth is not there, or truth or data were changed.
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
        raise TrialError(f"{error} Whoever made the trial has its truth: --truth DIR.") from None
    if hashlib.sha256(text).hexdigest() != number[1]:
        raise _changed(path, f"does not match the hash in {folder / SEAL}")
    worlds = json.loads(text)["worlds"]
    for name, world in worlds.items():
        there = {file: read_bytes(folder / name / file) for file in FOLDER if (folder / name / file).is_file()}
        if _hash_of(there) != world["data"]:
            raise _changed(folder / name, "holds other data than were made")
    return {name: world["truth"] for name, world in worlds.items()}


def _hash_of(files: Mapping[str, bytes]) -> str:
    """SHA-256 of a data set's files, names included."""
    total = hashlib.sha256()
    for name in filter(files.__contains__, FOLDER):
        total.update(f"{name} {hashlib.sha256(files[name]).hexdigest()}\n".encode())
    return total.hexdigest()


def _changed(path: Path, wrong: str) -> TrialError:
    return TrialError(
        f"{path} {wrong}: something was changed after the trial was made. Its score would mean nothing; make the trial"
        " again."
    )
