"""Selected points of a cloud with added columns, and file formats: PLY, PCD, LAS and E57."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO, final

import numpy as np
from scipy.spatial import cKDTree

from robolaser.arrays import Array
from robolaser.data.result_folder import write_streamed, write_together
from robolaser.errors import ScanError, unwritable
from robolaser.plugins import extra
from robolaser.scan.ply import COLOURS, DIGITS, NORMALS, VERTEX, Vertices, plain, positions_of, write_ply

NEIGHBOURS = 16  # points, with the point itself, whose plane gives its normal
BLOCK = 100_000  # points whose neighbours are in memory at a time: 50 MB
GATHERED = 2_000_000  # least number of points between two merges of voxels
SAMPLED = 200_000  # points of a sample: more do not improve a plane or a picture


def within(pieces: Iterable[Vertices], region: Array) -> Iterator[Vertices]:
    """The points inside a box, (3, 2): least and largest x, y and z in the base frame [m]; infinite where open."""
    for piece in pieces:
        places = positions_of(piece)
        yield piece[((places >= region[:, 0]) & (places <= region[:, 1])).all(axis=1)]


def one_per_voxel(pieces: Iterable[Vertices], size_m: float) -> Vertices:
    """The mean of the points in each cube of a grid, in the order of their first points, (k,).

    `std` is the RMS of theirs: neighbours share the arm's errors. `pose` is that of the first.
    """
    kept: list[tuple[Array, Array, Vertices]] = []
    count, most = 0, GATHERED
    for piece in pieces:
        values = np.stack([piece[name].astype(np.float64) for name in ("x", "y", "z", "std", "intensity")], axis=-1)
        values[:, 3] **= 2
        cells = np.floor(positions_of(piece) / size_m)
        kept.append((cells, np.column_stack([values, np.ones(len(piece))]), piece))
        count += len(piece)
        if count > most:
            kept = [_gathered(kept)]
            count = len(kept[0][0])
            most = max(GATHERED, 2 * count)  # else many voxels would be merged with each piece
    _, sums, cloud = _gathered(kept)
    means = sums[:, :5] / sums[:, 5:]
    for column, name in enumerate(("x", "y", "z", "std", "intensity")):
        cloud[name] = np.sqrt(means[:, 3]) if name == "std" else means[:, column]
    return cloud


def _gathered(kept: list[tuple[Array, Array, Vertices]]) -> tuple[Array, Array, Vertices]:
    """Cells, sums and first points of all, each cell once."""
    cells, sums, cloud = (np.concatenate(column) for column in zip(*kept, strict=True))
    _, first, inverse = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    total = np.zeros((len(first), sums.shape[1]))
    np.add.at(total, inverse.ravel(), sums)
    order = np.argsort(first)
    return cells[first[order]], total[order], cloud[first[order]]


def with_normals(cloud: Vertices, cameras: Array) -> Vertices:
    """The points with unit normals `nx`, `ny`, `nz`: of the plane through their neighbours, towards the camera.

    Its positions in the base frame are by pose, (poses, 3) [m].
    """
    places = positions_of(cloud)
    tree, count = cKDTree(places), min(NEIGHBOURS, len(cloud))
    normals = np.empty((len(cloud), 3))
    for begin in range(0, len(cloud), BLOCK):
        here = slice(begin, begin + BLOCK)
        around = places[tree.query(places[here], k=count)[1].reshape(-1, count)]
        around -= around.mean(axis=1, keepdims=True)
        normal = np.linalg.eigh(np.swapaxes(around, 1, 2) @ around)[1][:, :, 0]
        away = ((cameras[cloud["pose"][here]] - places[here]) * normal).sum(axis=1) < 0
        normals[here] = np.where(away[:, None], -normal, normal)
    return _extended(cloud, NORMALS, normals.T)


def with_colours(cloud: Vertices) -> Vertices:
    """The points with `red`, `green`, `blue`: the grey of the stripe, which shows what the surface reflects."""
    grey = np.rint(_grey(cloud)).astype(np.uint8)
    return _extended(cloud, COLOURS, [grey, grey, grey])


def _grey(cloud: Vertices) -> Array:
    """The grey of the stripe at each point, 0 to 255; 0 where it is not known, as of points.csv."""
    return np.asarray(np.clip(np.nan_to_num(cloud["intensity"]), 0, 255))


def _extended(cloud: Vertices, fields: list[tuple[str, str]], columns: Iterable[Any]) -> Vertices:
    out = np.empty(len(cloud), [*cloud.dtype.descr, *fields])
    for name in cloud.dtype.names or ():
        out[name] = cloud[name]
    for (name, _), column in zip(fields, columns, strict=True):
        out[name] = column
    return out


@final
class Subsample:
    """Evenly taken points of a cloud of unknown size: all at first, then ever fewer, at most so many."""

    def __init__(self, most: int = SAMPLED) -> None:
        self._most, self._every, self._seen = most, 1, 0
        self._kept: list[Vertices] = []

    def watch(self, pieces: Iterable[Vertices]) -> Iterator[Vertices]:
        """Yield pieces, (n,) of VERTEX each, and sample their points."""
        for piece in pieces:
            self._kept.append(piece[-self._seen % self._every :: self._every].copy())
            self._seen += len(piece)
            while sum(map(len, self._kept)) > self._most:
                self._kept = [self.vertices[::2].copy()]
                self._every *= 2
            yield piece

    @property
    def vertices(self) -> Vertices:
        """The sampled points in order, (m,) of VERTEX."""
        return np.concatenate([np.empty(0, VERTEX), *self._kept])


LAS_STEP_M = 1e-6  # LAS stores whole numbers: of micrometres, which reach 2 km
LAS_INTENSITY = 257  # LAS counts intensity and colours to 65535, an image to 255
_PCD = {"f": "F", "i": "I", "u": "U"}


def write_cloud(path: Path, pieces: Iterable[Vertices], comments: Sequence[str]) -> int:
    """Write a cloud in the format of the file's suffix, and return the number of its points.

    PLY and PCD are written piece by piece; LAS and E57 are collected in memory first.

    Args:
        path: The file, whose name ends with one of FORMATS.
        pieces: Points, (n,) each, of VERTEX or that with normals or colours; all alike.
        comments: Lines of text; a PLY has them all, E57 and LAS the first.

    Raises:
        DependencyMissing: The format's library is not installed.
        ScanError: There is no point.
        OutputError: Writing fails.
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
            *(f"# {plain(line)}" for line in comments),
            "VERSION 0.7",
            f"FIELDS {' '.join(dtype.names or ())}",
            f"SIZE {' '.join(str(kind.itemsize) for kind in kinds)}",
            f"TYPE {' '.join(_PCD[kind.kind] for kind in kinds)}",
            f"COUNT {' '.join('1' for _ in kinds)}",
            f"WIDTH {count:0{DIGITS}d}",
            "HEIGHT 1",
            "VIEWPOINT 0 0 0 1 0 0 0",
            f"POINTS {count:0{DIGITS}d}",
            "DATA binary",
        ]
        return ("\n".join(lines) + "\n").encode("ascii")

    return write_streamed(path, head, pieces)


def _las(path: Path, pieces: Iterable[Vertices], comments: Sequence[str], dtype: np.dtype[Any]) -> int:
    laspy = _writer("laspy", "LAS")
    cloud, names = np.concatenate(list(pieces)), dtype.names or ()
    header = laspy.LasHeader(point_format=7 if "red" in names else 6, version="1.4")
    header.scales, header.offsets = np.full(3, LAS_STEP_M), np.zeros(3)
    header.system_identifier = plain(comments[0])[:32] if comments else "robolaser"
    own = [name for name in names if name not in {"x", "y", "z", "intensity", "red", "green", "blue"}]
    header.add_extra_dims([laspy.ExtraBytesParams(name, dtype[name].str[1:]) for name in own])
    las = laspy.LasData(header)
    las.x, las.y, las.z = positions_of(cloud).T
    las.intensity = _grey(cloud) * LAS_INTENSITY
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
    columns["intensity"] = _grey(cloud).astype(np.float64)
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


FORMATS: Mapping[str, Callable[[Path, Iterable[Vertices], Sequence[str], np.dtype[Any]], int]] = {
    ".ply": write_ply, ".pcd": _pcd, ".las": _las, ".e57": _e57,
}  # fmt: skip
"""Writers of clouds, by suffix."""
