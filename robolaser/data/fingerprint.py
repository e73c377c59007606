"""A digest of a data set: two that differ in any number have different ones."""

import hashlib
from collections.abc import Mapping, Sequence
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
    return _digest(repr(_plain(values)).encode())


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _plain(value: Any) -> Any:
    """Lists, dictionaries and texts that say the same."""
    if isinstance(value, np.ndarray):
        return [value.dtype.str, value.shape, _digest(value.tobytes())]
    if is_dataclass(value) and not isinstance(value, type):
        names = [one.name for one in fields(value) if one.compare]
        uncounted = WORDS if {"poses", "points"} <= set(names) else frozenset()
        return [type(value).__name__, _plain({name: getattr(value, name) for name in names if name not in uncounted})]
    if isinstance(value, Mapping):
        return {name: _plain(value[name]) for name in sorted(value)}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(one) for one in value]
    return value
