"""The sealed truth: encrypted, with a key that stays with whoever made the trial, and a hash beside each data set."""

import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from robolaser.bounded_reading import SEALED_BYTES, read_bytes, read_text
from robolaser.data.atomic_write import write_text
from robolaser.data.writing import FOLDER
from robolaser.errors import DataError, TrialError, unwritable

FORMAT = "robolaser-seal/3"
TRUTH = "truth.sealed"
SEAL = "seal.txt"


def key_beside(folder: Path) -> Path:
    """Where the key of a trial lies unless it is said: beside the folder, which may be given away."""
    named = folder if folder.name not in ("", "..") else folder.resolve()
    return named.with_name(f"{named.name}.key")


def seal(folder: Path, truths: Mapping[str, Mapping[str, Any]], rng: np.random.Generator, key: Path) -> None:
    """Encrypt the truth about data sets, with their hashes, and write a hash of it into each.

    Args:
        folder: Of the trial; each data set lies in it under its name.
        truths: By data set.
        rng: Where the salts come from, without which a guess could be checked against the hash.
        key: File for the key, readable by its owner alone; an earlier key is replaced.

    Raises:
        OutputError: The key cannot be written.
    """
    from cryptography.fernet import Fernet  # noqa: PLC0415 - only trials need it

    worlds = {}
    for name, truth in truths.items():
        salt = rng.bytes(16).hex()
        worlds[name] = {"salt": salt, "truth": truth, "data": data_hash(folder / name)}
        write_text(folder / name / SEAL, f"sha256 {_hash(salt, truth)}\n")
    secret = Fernet.generate_key()
    _write_secret(key, secret)
    text = json.dumps({"format": FORMAT, "worlds": worlds}, sort_keys=True)
    write_text(folder / TRUTH, Fernet(secret).encrypt(text.encode()).decode() + "\n")


def unseal(folder: Path, key: Path) -> dict[str, dict[str, Any]]:
    """The truth about each data set of a trial.

    Raises:
        TrialError: There is no truth or no key that opens it, a data set's hash is another's, or its data were changed.
    """
    worlds = _opened(folder, key)
    for name, world in worlds.items():
        path = folder / name / SEAL
        if not path.is_file():
            raise _broken(path, "is not there")
        if read_text(path).split()[-1:] != [_hash(world["salt"], world["truth"])]:
            raise _broken(path, "does not match the truth in truth.sealed")
        if data_hash(folder / name) != world["data"]:
            raise _broken(folder / name, "holds other data than were made")
    return {name: world["truth"] for name, world in worlds.items()}


def data_hash(dataset: Path) -> str:
    """SHA-256 of a data set's files, names included."""
    total = hashlib.sha256()
    for name in FOLDER:
        file = dataset / name
        if file.is_file():
            total.update(f"{name} {hashlib.sha256(read_bytes(file)).hexdigest()}\n".encode())
    return total.hexdigest()


def _opened(folder: Path, key: Path) -> dict[str, Any]:
    from cryptography.fernet import Fernet, InvalidToken  # noqa: PLC0415

    sealed = folder / TRUTH
    if not sealed.is_file() or sealed.stat().st_size > SEALED_BYTES:
        raise TrialError(
            f"{folder} has no truth.sealed that can be read, so it is not a blind trial. Make one with"
            " `robolaser challenge new`."
        )
    try:
        said = json.loads(Fernet(_secret(key)).decrypt(read_bytes(sealed, SEALED_BYTES).strip()))
        if said["format"] == FORMAT:
            return dict(said["worlds"])
    except (InvalidToken, ValueError, KeyError, TypeError):
        pass
    raise TrialError(f"{key} does not open {sealed}: it is the key of another trial, or one of the two was changed.")


def _secret(key: Path) -> bytes:
    try:
        return read_bytes(key).strip()
    except DataError as error:
        raise TrialError(f"{error} Whoever made the trial has its key: --key FILE.") from None


def _hash(salt: str, truth: Mapping[str, Any]) -> str:
    return hashlib.sha256(f"{salt}{json.dumps(truth, sort_keys=True)}".encode()).hexdigest()


def _write_secret(path: Path, secret: bytes) -> None:
    try:
        path.unlink(missing_ok=True)
        with open(path, "xb", opener=lambda name, flags: os.open(name, flags, 0o600)) as file:
            file.write(secret + b"\n")
    except OSError as error:
        raise unwritable(path, error.strerror or str(error)) from None


def _broken(path: Path, wrong: str) -> TrialError:
    return TrialError(
        f"{path} {wrong}: something was changed after the trial was made. Its score would mean nothing; make the trial"
        " again."
    )
