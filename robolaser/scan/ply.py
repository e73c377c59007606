"""Point clouds on disk: binary PLY, written piece by piece, completely or not at all."""

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robolaser.arrays import Array
from robolaser.bounded_reading import CLOUD_BYTES, opened
from robolaser.data.result_folder import write_streamed
from robolaser.errors import DataError

VERTEX = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("std", "<f4"), ("pose", "<i4"), ("intensity", "<f4")])
"""Position in the base frame [m]; scatter [m]; row of poses.csv, the first is 0; grey of the stripe, 0 to 255."""
Vertices = NDArray[np.void]
NORMALS = [(name, "<f4") for name in ("nx", "ny", "nz")]
COLOURS = [(name, "u1") for name in ("red", "green", "blue")]
_STORED = [np.dtype([*VERTEX.descr, *normals, *colours]) for normals in ([], NORMALS) for colours in ([], COLOURS)]

_TYPES = {"<f4": "float", "<i4": "int", "|u1": "uchar"}
DIGITS = 20  # of the largest count
LONGEST = 200  # of a comment
MOST_HEADER = 1 << 16  # bytes in which the header of a cloud of ours ends


def write_ply(path: Path, pieces: Iterable[Vertices], comments: Sequence[str], dtype: np.dtype[Any] = VERTEX) -> int:
    """Write a cloud piece by piece, (n,) each, with comments at the head of the file; the number of vertices."""
    return write_streamed(path, lambda count: _header(count, comments, dtype), pieces)


def map_ply(path: Path) -> Vertices:
    """Map a cloud that `write_ply` wrote into memory, (n,) of VERTEX, or of it with normals and colours.

    Raises:
        DataError: It is no such file, or cut off.
    """
    with opened(path, CLOUD_BYTES) as file:
        head = file.read(MOST_HEADER)
        size = os.fstat(file.fileno()).st_size
    lines, end, _ = head.partition(b"end_header\n")
    header = [line for line in lines.decode("ascii", "replace").splitlines() if not line.startswith("comment ")]
    counts = [line.split()[-1] for line in header if line.startswith("element vertex ")]
    dtype = next((one for one in _STORED if header == _head(counts[0] if counts else "0", one)), None)
    if not end or dtype is None:
        raise _unreadable(path, "its header is not that of such a cloud")
    count, start = int(counts[0]), len(lines) + len(end)
    if size != start + count * dtype.itemsize:
        raise _unreadable(path, f"its header states {count} points, but the file is shorter or longer")
    return np.memmap(path, dtype, mode="r", offset=start, shape=(count,)) if count else np.empty(0, dtype)


def _unreadable(path: Path, reason: str) -> DataError:
    return DataError(f"Cannot show {path}: {reason}. Expected a cloud as `robolaser scan` writes it.", file=path)


def positions_of(vertices: Vertices) -> Array:
    """The positions of vertices, (n, 3) [m]."""
    return np.stack([vertices[axis] for axis in "xyz"], axis=-1).astype(np.float64)


def _head(count: str, dtype: np.dtype[Any]) -> list[str]:
    """The header's lines without comments and end."""
    fields = [f"property {_TYPES[dtype[name].str]} {name}" for name in dtype.names or ()]
    return ["ply", "format binary_little_endian 1.0", f"element vertex {count}", *fields]


def _header(count: int, comments: Sequence[str], dtype: np.dtype[Any]) -> bytes:
    """The header; a comment pads it to the same length for every count."""
    first, second, *rest = _head(str(count), dtype)
    texts = [f"comment {plain(line)}" for line in comments]
    rest[0:0] = [f"comment {'.' * (DIGITS - len(str(count)))}"]
    return ("\n".join([first, second, *texts, *rest, "end_header"]) + "\n").encode("ascii")


def plain(text: str) -> str:
    """One short line of ASCII."""
    shown = "".join(letter if letter.isprintable() else " " for letter in text)
    return shown.encode("ascii", "replace").decode("ascii")[:LONGEST]
