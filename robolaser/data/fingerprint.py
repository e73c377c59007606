"""A digest of a data set: two that differ in any number have different ones."""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

WORDS = frozenset({"name", "source", "licence", "folder", "warnings"})
"""Descriptions of a data set and its folder, which its residuals do not depend on."""


def fingerprint(*values: Any) -> str:
    """A digest of values of any kind, 64 hexadecimal digits.

    All fields of a data set count except `WORDS` and those that follow from others (`compare=False`), so new fields are
    included without a change here.

    Args:
        values: Data sets, further dataclasses, mappings, sequences, arrays, texts and numbers, one within another.
    """
    digest = hashlib.sha256()
    for part in _parts(values):
        digest.update(len(part).to_bytes(8, "little") + part)
    return digest.hexdigest()


def _parts(value: Any) -> Iterator[bytes]:
    if isinstance(value, np.ndarray):
        yield f"{value.dtype.str} {value.shape}".encode()
        yield value.tobytes()
    elif is_dataclass(value) and not isinstance(value, type):
        names = [one.name for one in fields(value) if one.compare]
        uncounted = WORDS if {"poses", "points"} <= set(names) else frozenset()
        yield type(value).__name__.encode()
        yield from _parts({name: getattr(value, name) for name in names if name not in uncounted})
    elif isinstance(value, Mapping):
        yield f"{len(value)} by name".encode()
        for name in sorted(value):
            yield from _parts((name, value[name]))
    elif isinstance(value, Sequence) and not isinstance(value, str):
        yield f"{len(value)} in order".encode()
        for one in value:
            yield from _parts(one)
    else:
        yield repr(value).encode()
