"""Untrusted files: regular ones of limited size, parsed in bounded time.

All limits of size and depth are here; each is some ten times the largest known file.
"""

import io
import re
import stat
import tomllib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import msgspec

from robolaser.errors import unreadable

SETTINGS_BYTES = 1 << 21  # of a TOML file: tomllib reads a megabyte a second
ROBOT_BYTES = 10_000_000  # of a robot's description; the largest published ones (humanoids with hands) have 300 kB
TEXT_BYTES = 1 << 28  # of another text that is read whole: results, tables of other programs
TABLE_BYTES = 1 << 33  # of a CSV table, which is read piece by piece
CLOUD_BYTES = 1 << 40  # of a cloud or of line centres, which are mapped into memory and read piece by piece
YAML_BYTES = 50_000_000
IMAGE_BYTES = 1 << 28
IMAGE_PIXELS = 150_000_000  # the largest cameras have 150 megapixels
KEY_PARTS = 50  # of a dotted key: tomllib's time grows with the cube of their number
XML_DEPTH = 60
XML_ATTRIBUTES = 100

_PART = r"""(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')[ \t]*+"""
_CHAIN = re.compile(rf"(?<![\w.\\-])(?:{_PART}\.[ \t]*+){{{KEY_PARTS}}}")
"""It begins neither inside a part nor after one, so that the search takes linear time."""
_LONG_INTEGER = re.compile(r"(?<!\w)0[box]\w{3000}")  # too long for decimals, by Python's own limit


@contextmanager
def opened(path: Path, most_bytes: int, *, text: bool = False, newline: str | None = None) -> Iterator[IO[Any]]:
    """Open a regular file to read, as bytes or as text without its byte order mark.

    Raises:
        DataError: It is not there, no regular file (a pipe would never end), too large, or not UTF-8.
    """
    if "\0" in str(path):
        raise unreadable(path, "its name has a null character")
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode):
            raise unreadable(path, "it is not a regular file")
        if found.st_size > most_bytes:
            raise unreadable(path, f"it has {found.st_size} bytes, and no such file more than {most_bytes}")
        with path.open("r" if text else "rb", encoding="utf-8-sig" if text else None, newline=newline) as file:
            yield file
    except OSError as error:
        raise unreadable(path, error.strerror or str(error)) from None
    except UnicodeDecodeError:
        raise unreadable(path, f"byte {_undecodable(path)} is not UTF-8 text; save it as UTF-8") from None


def read_bytes(path: Path, most_bytes: int = TEXT_BYTES) -> bytes:
    """A whole file.

    Raises:
        DataError: As `opened`.
    """
    with opened(path, most_bytes) as file:
        return bytes(file.read(most_bytes))


def read_text(path: Path, most_bytes: int = TEXT_BYTES) -> str:
    """A whole text.

    Raises:
        DataError: As `opened`.
    """
    with opened(path, most_bytes, text=True) as file:
        return str(file.read(most_bytes))


def read_json(path: Path) -> Any:
    """The contents of a JSON file.

    Raises:
        DataError: As `opened`, or it is no JSON, or nested too deeply.
    """
    try:
        return msgspec.json.decode(read_text(path))
    except RecursionError:
        reason = "it is not JSON that can be read: it is nested too deeply"
    except (ValueError, msgspec.MsgspecError) as error:
        reason = f"it is not JSON ({error})"
    raise unreadable(path, reason)


def parse_toml(text: str) -> dict[str, Any]:
    """The contents of a TOML text.

    Raises:
        ValueError: It is not TOML, or nested more deeply than any such file.
    """
    try:
        if _CHAIN.search(text):
            raise RecursionError
        if _LONG_INTEGER.search(text):
            raise ValueError("it has an integer of thousands of digits")
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def pixels_of(data: bytes) -> tuple[int, int] | None:
    """Width and height in an image's header; None if it is no image, or of more pixels than any camera's.

    Nothing is decoded: some kilobytes can become gigabytes.
    """
    from PIL import Image  # noqa: PLC0415 - slow to import

    try:
        with warnings.catch_warnings(action="ignore"), Image.open(io.BytesIO(data)) as image:
            width, height = image.size
    except (OSError, ValueError, SyntaxError, OverflowError, Image.DecompressionBombError):
        return None
    return (width, height) if 0 < width * height <= IMAGE_PIXELS else None


def decoded(data: bytes, flags: int) -> Any:
    """An image decoded by OpenCV, (h, w) or (h, w, colours); None where it is damaged, or as `pixels_of`.

    It is as the sensor read it: how the camera was held, as EXIF states, would turn its frame.

    Args:
        data: The file's.
        flags: OpenCV's IMREAD_....
    """
    import cv2  # noqa: PLC0415 - slow to import
    import numpy as np  # noqa: PLC0415

    flags |= cv2.IMREAD_IGNORE_ORIENTATION
    return None if pixels_of(data) is None else cv2.imdecode(np.frombuffer(data, np.uint8), flags)


def _undecodable(path: Path) -> int:
    try:
        path.read_bytes().decode()
    except UnicodeDecodeError as error:
        return error.start
    return 0
