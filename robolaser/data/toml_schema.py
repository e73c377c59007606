"""TOML files read against dataclasses: a value of every declared type, or a sentence about the first that is wrong."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import inspect

from robolaser.bounded_reading import SETTINGS_BYTES, parse_toml, read_text
from robolaser.errors import DataError, meant, near

T = TypeVar("T")
Key = tuple[str | int, ...]
Positive = Annotated[float, msgspec.Meta(gt=0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0)]

_FAULT = re.compile(r"(?:.*missing required field `(?P<missing>[^`]*)`|.*?)(?: - at `\$(?P<at>.*)`)?")
_STEP = re.compile(r"\.([^.\[\]]+)|\[(\d+)\]")
LARGEST = 2**63 - 1
MOST_SHOWN = 80


def read_toml(path: Path, expected: str = "", folder: str = "") -> dict[str, Any]:
    """Parse a TOML file.

    Args:
        path: The file.
        expected: The format that it must state; "": any.
        folder: What a folder with such a file is, for who names another one.

    Raises:
        DataError: It is not there, not text or not TOML, is nested more deeply than any such file, or is of another
            format, or of a later version.
    """
    if folder and not path.is_file():
        what = f"has no {path.name}" if path.parent.exists() else "does not exist"
        raise DataError(f"{path.parent} {what}. {folder}", file=path)
    text = read_text(path, SETTINGS_BYTES)
    try:
        contents = parse_toml(text)
    except ValueError as error:
        raise DataError(f"{path} is not valid TOML: {error}.", file=path) from None
    if expected and "format" not in contents:
        raise lacking(path.name, "format", f': expected "{expected}"')
    if expected and contents["format"] != expected:
        raise refused(path.name, "format", f"{contents['format']!r}, but this program reads '{expected}'.")
    return contents


def typed(values: object, type_: type[T], *, file: str, at: Key = ()) -> T:
    """Values of a TOML file as a dataclass, nested ones included.

    Args:
        values: The file's contents, or a part of them.
        type_: A dataclass; its annotations are the schema, with bounds by `msgspec.Meta`.
        file: The file's name, for messages.
        at: Key of that part, for messages.

    Raises:
        DataError: A key is missing or unknown, or a value is not what the schema declares.
    """
    schema, entries = inspect.type_info(type_), dict(_entries(values))
    for key in entries:
        known = _fields(_part(schema, key[:-1])) if isinstance(key[-1], str) else {}
        if known and key[-1] not in known:
            raise refused(file, _name(at + key), f"this key is not known.{near(str(key[-1]), known)}")
    for key, value in entries.items():
        is_huge = isinstance(value, int) and abs(value) > LARGEST
        if is_huge or (isinstance(value, float) and not math.isfinite(value)):
            raise wrong(file, at + key, value, _expected(_part(schema, key), key[-1], "a finite number"))
    try:
        return msgspec.convert(values, type_)
    except msgspec.ValidationError as fault:
        found = _FAULT.fullmatch(str(fault))
        assert found is not None  # the pattern takes any text
        key = tuple(name or int(number) for name, number in _STEP.findall(found["at"] or ""))
        if found["missing"]:
            key = (*key, found["missing"])
            raise lacking(file, _name(at + key), f": expected {_expected(_part(schema, key), key[-1])}") from None
        part = _part(schema, key)
        choices = [str(value) for value in part.values] if isinstance(part, inspect.LiteralType) else []
        raise wrong(file, at + key, entries[key], _expected(part, key[-1]), choices) from None


def wrong(file: str, key: Key, value: object, expected: str, choices: Sequence[str] = ()) -> DataError:
    """The error of a value that is not what is expected.

    Args:
        file: Of the value.
        key: Its tables and its name.
        value: What stands there.
        expected: What should.
        choices: The texts that could have been meant.
    """
    shown = repr(value) if len(repr(value)) <= MOST_SHOWN else f"{repr(value)[:MOST_SHOWN]}..."
    guess = meant(value, choices) if isinstance(value, str) else ""
    return refused(file, _name(key), f"{shown}, expected {expected}.{guess}")


def refused(file: str, name: str, why: str) -> DataError:
    """The error of a key, as messages name it."""
    return DataError(f"{file}, {name}: {why}", file=file, column=name)


def lacking(file: str, name: str, why: str) -> DataError:
    """The error of a key or a table that is not there."""
    return DataError(f"{file} lacks {name}{why}.", file=file, column=name)


def _name(key: Key) -> str:
    """How messages name a key: "[target] distances_m, entry 2"; "[[sphere]] radius_m, entry 1"."""
    words = [part for part in key if isinstance(part, str)]
    entries = "".join(f", entry {part + 1}" for part in key if isinstance(part, int))
    table = "" if len(words) == 1 else f"[[{words[0]}]] " if isinstance(key[1], int) else f"[{words[0]}] "
    return f"{table}{'.'.join(words[1:] or words)}{entries}"


def _entries(values: object, at: Key = ()) -> Iterator[tuple[Key, object]]:
    """All values within values, tables and lists before what is in them."""
    inner = values.items() if isinstance(values, Mapping) else enumerate(values) if isinstance(values, list) else ()
    for key, value in inner:
        yield (*at, key), value
        yield from _entries(value, (*at, key))


def _part(schema: inspect.Type, key: Key) -> inspect.Type | None:
    """The schema of a key."""
    if not key:
        return schema
    first, *rest = key
    if isinstance(first, str):
        part = _fields(schema).get(first)
        return part and _part(part, tuple(rest))
    for part in _alternatives(schema):
        if isinstance(part, inspect.VarTupleType):
            return _part(part.item_type, tuple(rest))
        if isinstance(part, inspect.TupleType) and first < len(part.item_types):
            return _part(part.item_types[first], tuple(rest))
    return None


def _fields(schema: inspect.Type | None) -> dict[str, inspect.Type]:
    """The keys that a table may have."""
    parts = _alternatives(schema) if schema else ()
    return {one.name: one.type for part in parts if isinstance(part, inspect.DataclassType) for one in part.fields}


def _alternatives(schema: inspect.Type) -> tuple[inspect.Type, ...]:
    types = schema.types if isinstance(schema, inspect.UnionType) else (schema,)
    return tuple(part for part in types if not isinstance(part, inspect.NoneType))


def _expected(schema: inspect.Type | None, name: str | int, otherwise: str = "another value") -> str:
    """What a schema asks for under a name, in words."""
    words = [] if schema is None else [_in_words(part, name) for part in _alternatives(schema)]
    return " or ".join(filter(None, words)) or otherwise


def _in_words(schema: inspect.Type, name: str | int) -> str:
    match schema:
        case inspect.IntType(ge=int(least), le=most):
            words = f"a whole number from {least}" + ("" if most is None else f" to {most}")
        case inspect.FloatType(gt=least, ge=from_):
            words = "a positive number" if least == 0 else "a number, 0 or more" if from_ == 0 else "a finite number"
        case inspect.StrType(pattern=str()):
            words = "a name of letters, digits, - and _"
        case inspect.StrType(min_length=least):
            words = "a text that is not empty" if least else "a text"
        case inspect.BoolType():
            words = "true or false"
        case inspect.LiteralType():
            words = " or ".join(f'"{value}"' for value in schema.values)
        case inspect.TupleType():
            parts = [_in_words(part, name) for part in schema.item_types]
            words = f"a list of {len(parts)}: {', '.join(parts) if len(set(parts)) > 1 else f'each {parts[0]}'}"
        case inspect.VarTupleType(item_type=inspect.DataclassType()):
            words = f"sections [[{name}]]"
        case inspect.VarTupleType():
            words = f"a list, each {_in_words(schema.item_type, name)}"
        case inspect.DictType(value_type=inspect.FloatType()):
            words = f"a table of names, each with {_in_words(schema.value_type, name)}"
        case inspect.DataclassType() | inspect.DictType():
            words = f"a section [{name}]"
        case _:
            words = ""
    return words
