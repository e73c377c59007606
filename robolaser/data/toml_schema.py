"""TOML and JSON read into dataclasses: values of declared types, or a message on the first wrong one."""

import math
import operator
import re
from collections.abc import Iterable, Mapping, Sequence
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

SCALARS: Mapping[type, Any] = {
    inspect.NoneType: type(None), inspect.StrType: str, inspect.IntType: int, inspect.FloatType: (int, float),
}  # fmt: skip
LARGEST = 2**63 - 1
MOST_SHOWN = 80


def read_toml(path: Path, expected: str = "", folder: str = "") -> dict[str, Any]:
    """Parse a TOML file.

    Args:
        path: The file.
        expected: The format that it must state; "": any.
        folder: Description of a folder with such a file, for messages.

    Raises:
        DataError: It is missing, not text or not TOML, is nested more deeply than any such file, or is of another
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


def typed(values: object, type_: type[T], *, file: str, at: Key = (), others: bool = False) -> T:
    """Values of a TOML or JSON file as a dataclass, nested ones included.

    Args:
        values: The file's contents, or a part of them.
        type_: A dataclass; its annotations are the schema, with bounds by `msgspec.Meta`.
        file: The file's name, for messages.
        at: Key of that part, for messages.
        others: Whether the file may have further keys.

    Raises:
        DataError: A key is missing or unknown, or a value is not what the schema declares.
    """
    _check(values, inspect.type_info(type_), file, at, others=others)
    return msgspec.convert(values, type_)


def _check(value: object, schema: inspect.Type, file: str, key: Key, *, others: bool) -> None:
    """Check that a value, with all nested ones, matches a schema."""
    inner: Iterable[tuple[str | int, object, inspect.Type]] | None = None
    for part in schema.types if isinstance(schema, inspect.UnionType) else (schema,):
        match part, value:
            case inspect.DataclassType(), Mapping():
                types = {one.encode_name: one.type for one in part.fields}
                if unknown := [name for name in value if name not in types and not others]:
                    raise refused(file, _name((*key, unknown[0])), f"this key is not known.{near(unknown[0], types)}")
                if missing := [one.name for one in part.fields if one.required and one.name not in value]:
                    expected = _expected(types[missing[0]], missing[0])
                    raise lacking(file, _name((*key, missing[0])), f": expected {expected}")
                inner = [(name, value[name], types[name]) for name in value if name in types]
            case inspect.DictType(), Mapping():
                inner = [(name, one, part.value_type) for name, one in value.items()]
            case inspect.TupleType(), list() if len(value) == len(part.item_types):
                inner = [(i, *one) for i, one in enumerate(zip(value, part.item_types, strict=True))]
            case inspect.VarTupleType() | inspect.ListType(), list():
                if len(value) >= (part.min_length or 0) and len(value) <= (part.max_length or len(value)):
                    inner = [(i, one, part.item_type) for i, one in enumerate(value)]
            case _ if _fits(value, part):
                inner = ()
    if inner is None:
        choices = [str(one) for one in schema.values] if isinstance(schema, inspect.LiteralType) else []
        raise wrong(file, key, value, _expected(schema, key[-1]), choices)
    for name, one, type_ in inner:
        _check(one, type_, file, (*key, name), others=others)


def _fits(value: Any, part: inspect.Type) -> bool:
    """Whether a value without nested ones matches a schema."""
    if isinstance(part, inspect.AnyType | inspect.LiteralType):
        return isinstance(part, inspect.AnyType) or value in part.values
    if isinstance(value, bool):
        return isinstance(part, inspect.BoolType)
    if not isinstance(value, SCALARS.get(type(part), ())):
        return False
    if isinstance(part, inspect.StrType):
        return len(value) >= (part.min_length or 0) and re.search(part.pattern or "", value) is not None
    if isinstance(part, inspect.IntType | inspect.FloatType):
        ends = ((part.ge, operator.ge), (part.gt, operator.gt), (part.le, operator.le), (part.lt, operator.lt))
        finite = math.isfinite(value) if isinstance(value, float) else abs(value) <= LARGEST
        return finite and all(end is None or holds(value, end) for end, holds in ends)
    return True


def wrong(file: str, key: Key, value: object, expected: str, choices: Sequence[str] = ()) -> DataError:
    """The error of an unexpected value, with the expected one in words; one of some texts may have been meant."""
    shown = repr(value) if len(repr(value)) <= MOST_SHOWN else f"{repr(value)[:MOST_SHOWN]}..."
    guess = meant(value, choices) if isinstance(value, str) else ""
    return refused(file, _name(key), f"{shown}, expected {expected}.{guess}")


def refused(file: str, name: str, why: str) -> DataError:
    """The error of a key, with its name for messages."""
    return DataError(f"{file}, {name}: {why}", file=file, column=name)


def lacking(file: str, name: str, why: str) -> DataError:
    """The error of a missing key or table."""
    return DataError(f"{file} lacks {name}{why}.", file=file, column=name)


def _name(key: Key) -> str:
    """A key's name in messages: "[target] distances_m, entry 2"; "[[sphere]] radius_m, entry 1"."""
    words = [part for part in key if isinstance(part, str)]
    entries = "".join(f", entry {part + 1}" for part in key if isinstance(part, int))
    table = "" if len(words) == 1 else f"[[{words[0]}]] " if isinstance(key[1], int) else f"[{words[0]}] "
    return f"{table}{'.'.join(words[1:] or words)}{entries}"


def _expected(schema: inspect.Type, name: str | int) -> str:
    """The values that a schema requires under a name, in words."""
    parts = schema.types if isinstance(schema, inspect.UnionType) else (schema,)
    return " or ".join(filter(None, (_in_words(part, name) for part in parts))) or "another value"


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
        case inspect.VarTupleType(item_type=inspect.DataclassType() | inspect.DictType()):
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
