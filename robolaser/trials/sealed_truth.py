"""The sealed truth: encrypted, with a key that stays with whoever made the trial, and a hash beside each data set."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from robolaser.bounded_reading import SEALED_BYTES, read_bytes, read_text
from robolaser.data.atomic_write import Contents, written_whole
from robolaser.data.result_folder import write_results
from robolaser.data.writing import FOLDER
from robolaser.errors import DataError, TrialError

FORMAT = "robolaser-seal/3"
TRUTH = "truth.sealed"
SEAL = "seal.txt"
DIAGNOSIS = "diagnosis/diagnosis.json"


def key_beside(folder: Path) -> Path:
    """Where the key of a trial lies unless it is said: beside the folder, which may be given away."""
    named = folder if folder.name not in ("", "..") else folder.resolve()
    return named.with_name(f"{named.name}.key")


def seal(
    folder: Path,
    files: Mapping[str, Mapping[str, str | None]],
    truths: Mapping[str, Mapping[str, Any]],
    rng: np.random.Generator,
    key: Path,
) -> None:
    """Write data sets, the truth about them, encrypted with their hashes, and a hash of it into each: all or nothing.

    Args:
        folder: Of the trial.
        files: What the files of each data set hold, by its name and theirs.
        truths: By data set.
        rng: Where the salts come from, without which a guess could be checked against the hash.
        key: File for the key, readable by its owner alone; an earlier key opens an earlier trial until this one is
            there, and is gone then.

    Raises:
        OutputError: The disk or the rights say no.
    """
    from cryptography.fernet import Fernet  # noqa: PLC0415 - only trials need it

    worlds, written = {}, dict[str, str | Contents | None]()
    for name, truth in truths.items():
        salt = rng.bytes(16).hex()
        there = {file: text.encode() for file, text in files[name].items() if text is not None}
        worlds[name] = {"salt": salt, "truth": truth, "data": _hash_of(there)}
        written |= {f"{name}/{file}": text for file, text in files[name].items()}
        written[f"{name}/{SEAL}"] = f"sha256 {_hash(salt, truth)}\n"
        written[f"{name}/{DIAGNOSIS}"] = None  # of the world that was here before
    secret = Fernet.generate_key()
    text = json.dumps({"format": FORMAT, "worlds": worlds}, sort_keys=True)
    written[TRUTH] = Fernet(secret).encrypt(text.encode()).decode() + "\n"
    _write_secret(key, [secret, *(_secrets(key) if key.exists() else ())])
    write_results(folder, written)
    _write_secret(key, [secret])


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
    return _hash_of({name: read_bytes(dataset / name) for name in FOLDER if (dataset / name).is_file()})


def _hash_of(files: Mapping[str, bytes]) -> str:
    total = hashlib.sha256()
    for name in filter(files.__contains__, FOLDER):
        total.update(f"{name} {hashlib.sha256(files[name]).hexdigest()}\n".encode())
    return total.hexdigest()


def _opened(folder: Path, key: Path) -> dict[str, Any]:
    from cryptography.fernet import Fernet, InvalidToken, MultiFernet  # noqa: PLC0415

    sealed = folder / TRUTH
    if not sealed.is_file() or sealed.stat().st_size > SEALED_BYTES:
        raise TrialError(
            f"{folder} has no truth.sealed that can be read, so it is not a blind trial. Make one with"
            " `robolaser challenge new`."
        )
    try:
        opened = json.loads(
            MultiFernet([*map(Fernet, _secrets(key))]).decrypt(read_bytes(sealed, SEALED_BYTES).strip())
        )
        if opened["format"] == FORMAT:
            return dict(opened["worlds"])
    except (InvalidToken, ValueError, KeyError, TypeError):
        pass
    raise TrialError(f"{key} does not open {sealed}: it is the key of another trial, or one of the two was changed.")


def _secrets(key: Path) -> list[bytes]:
    try:
        return read_bytes(key).split()
    except DataError as error:
        raise TrialError(f"{error} Whoever made the trial has its key: --key FILE.") from None


def _hash(salt: str, truth: Mapping[str, Any]) -> str:
    return hashlib.sha256(f"{salt}{json.dumps(truth, sort_keys=True)}".encode()).hexdigest()


def _write_secret(path: Path, secrets: Sequence[bytes]) -> None:
    with written_whole(path, mode=0o600) as file:
        file.write(b"\n".join(secrets) + b"\n")


def _broken(path: Path, wrong: str) -> TrialError:
    return TrialError(
        f"{path} {wrong}: something was changed after the trial was made. Its score would mean nothing; make the trial"
        " again."
    )
