"""Point clouds in the formats that other programs read: PLY, PCD, LAS and E57."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any, BinaryIO

import numpy as np

from robolaser.data.atomic_write import write_streamed, write_together
from robolaser.errors import ScanError, unwritable
from robolaser.plugins import extra
from robolaser.scan.ply import Vertices, positions_of, write_ply

LAS_STEP_M = 1e-6  # LAS stores whole numbers: of micrometres, which reach 2 km
LAS_INTENSITY = 257  # LAS counts intensity and colours to 65535, an image to 255
_PCD = {"f": "F", "i": "I", "u": "U"}
_DIGITS = 20


def write_cloud(path: Path, pieces: Iterable[Vertices], comments: Sequence[str]) -> int:
    """Write a cloud in the format that the file's name says, and give the number of its points.

    PLY and PCD are written as points come; LAS and E57 are gathered in memory first.

    Args:
        path: The file, whose name ends with one of FORMATS.
        pieces: Points, (n,) each, of VERTEX or that with normals or colours; all alike.
        comments: Lines for people; a PLY has them all, E57 and LAS the first.

    Raises:
        DependencyMissing: The format's library is not installed.
        ScanError: No point is there to be written.
        OutputError: The disk or the rights say no.
    """
    waiting = iter(pieces)
    first = next((piece for piece in waiting if len(piece)), None)
    if first is None:
        raise ScanError(
            "No point of the cloud is in --region, so there is nothing to write. Check its sides, in metres."
        )
    return FORMATS[path.suffix.lower()](path, chain([first], waiting), comments, first.dtype)


def _pcd(path: Path, pieces: Iterable[Vertices], comments: Sequence[str], dtype: np.dtype[Any]) -> int:
    kinds = [dtype[name] for name in dtype.names or ()]

    def head(count: int) -> bytes:
        lines = [
            *(f"# {line.encode('ascii', 'replace').decode()}" for line in comments),
            "VERSION 0.7",
            f"FIELDS {' '.join(dtype.names or ())}",
            f"SIZE {' '.join(str(kind.itemsize) for kind in kinds)}",
            f"TYPE {' '.join(_PCD[kind.kind] for kind in kinds)}",
            f"COUNT {' '.join('1' for _ in kinds)}",
            f"WIDTH {count:0{_DIGITS}d}",
            "HEIGHT 1",
            "VIEWPOINT 0 0 0 1 0 0 0",
            f"POINTS {count:0{_DIGITS}d}",
            "DATA binary",
        ]
        return ("\n".join(lines) + "\n").encode("ascii")

    return write_streamed(path, head, pieces)


def _las(path: Path, pieces: Iterable[Vertices], comments: Sequence[str], dtype: np.dtype[Any]) -> int:
    laspy = _writer("laspy", "LAS")
    cloud, names = np.concatenate(list(pieces)), dtype.names or ()
    header = laspy.LasHeader(point_format=7 if "red" in names else 6, version="1.4")
    header.scales, header.offsets = np.full(3, LAS_STEP_M), np.zeros(3)
    header.system_identifier = comments[0].encode("ascii", "replace").decode()[:32] if comments else "robolaser"
    own = [name for name in names if name not in {"x", "y", "z", "intensity", "red", "green", "blue"}]
    header.add_extra_dims([laspy.ExtraBytesParams(name, dtype[name].str[1:]) for name in own])
    las = laspy.LasData(header)
    las.x, las.y, las.z = positions_of(cloud).T
    las.intensity = np.clip(np.nan_to_num(cloud["intensity"]), 0, 255) * LAS_INTENSITY  # 0 where it is not known
    for name in own:
        las[name] = cloud[name]
    for name in {"red", "green", "blue"} & set(names):
        las[name] = cloud[name].astype(np.uint16) * LAS_INTENSITY
    write_together(path.parent, {path.name: las.write})
    return len(cloud)


def _e57(path: Path, pieces: Iterable[Vertices], comments: Sequence[str], dtype: np.dtype[Any]) -> int:
    pye57 = _writer("pye57", "E57")
    cloud = np.concatenate(list(pieces))
    columns = {f"cartesian{axis.upper()}": cloud[axis].astype(np.float64) for axis in "xyz"}
    columns["intensity"] = cloud["intensity"].astype(np.float64)
    for name in ("red", "green", "blue"):
        if name in (dtype.names or ()):
            columns[f"color{name.title()}"] = cloud[name]

    def write(file: BinaryIO) -> None:
        try:
            e57 = pye57.E57(file.name, mode="w")
            e57.write_scan_raw(columns, name=comments[0] if comments else "robolaser")
            e57.close()
        except RuntimeError as error:
            raise unwritable(path, str(error)) from None

    write_together(path.parent, {path.name: write})
    return len(cloud)


def _writer(library: str, what: str) -> Any:
    return extra(library, f"{library} is not installed, which writes {what}: pip install 'robolaser[clouds]'.")


FORMATS: Mapping[str, Callable[[Path, Iterable[Vertices], Sequence[str], np.dtype[Any]], int]] = MappingProxyType(
    {".ply": write_ply, ".pcd": _pcd, ".las": _las, ".e57": _e57}
)
"""How a cloud is written, by the end of its file's name."""
