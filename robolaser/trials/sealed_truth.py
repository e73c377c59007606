"""The sealed truth: a hash beside each data set, and the truths themselves, encoded, in one file."""

import base64
import hashlib
import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from robolaser.data.atomic_write import write_text
from robolaser.errors import TrialError

FORMAT = "robolaser-seal/2"
TRUTH = "truth.sealed"
SEAL = "seal.txt"
LINE = 120


def _hash(salt: str, truth: Mapping[str, Any]) -> str:
    return hashlib.sha256(f"{salt}{json.dumps(truth, sort_keys=True)}".encode()).hexdigest()


def seal(folder: Path, truths: Mapping[str, Mapping[str, Any]], rng: np.random.Generator) -> None:
    """Write the truth about data sets, wrapped so that nobody reads it by accident, and a hash into each.

    Args:
        folder: Of the trial; each data set lies in it under its name.
        truths: By data set.
        rng: Where the salts come from, without which a guess could be checked against the hash.
    """
    worlds = {}
    for name, truth in truths.items():
        salt = rng.bytes(16).hex()
        worlds[name] = {"salt": salt, "truth": truth}
        write_text(folder / name / SEAL, f"sha256 {_hash(salt, truth)}\n")
    packed = zlib.compress(json.dumps({"format": FORMAT, "worlds": worlds}, sort_keys=True).encode(), 9)
    text = base64.b64encode(packed).decode()
    write_text(folder / TRUTH, "\n".join(text[i : i + LINE] for i in range(0, len(text), LINE)) + "\n")


def unseal(folder: Path) -> dict[str, dict[str, Any]]:
    """The truth about each data set of a trial.

    Raises:
        TrialError: There is no truth that can be read, or a data set's hash is another's.
    """
    try:
        said = json.loads(zlib.decompress(base64.b64decode((folder / TRUTH).read_bytes())))
        worlds = dict(said["worlds"]) if said["format"] == FORMAT else None
    except (OSError, ValueError, zlib.error, KeyError, TypeError):
        raise _no_truth(folder) from None
    if worlds is None:
        raise _no_truth(folder)
    for name, world in worlds.items():
        path = folder / name / SEAL
        if not path.is_file():
            raise _broken(path, "is not there")
        if path.read_text(encoding="utf-8").split()[-1:] != [_hash(world["salt"], world["truth"])]:
            raise _broken(path, "does not match the truth in truth.sealed")
    return {name: world["truth"] for name, world in worlds.items()}


def _no_truth(folder: Path) -> TrialError:
    return TrialError(
        f"{folder} has no truth.sealed that can be read, so it is not a blind trial. "
        "Make one with `robolaser challenge new`."
    )


def _broken(seal_file: Path, wrong: str) -> TrialError:
    return TrialError(
        f"{seal_file} {wrong}: one of the two was changed after the trial was made. "
        "Its score would mean nothing; make the trial again."
    )
