"""OpenCV's FileStorage (YAML, XML, JSON) with lists of rotations and translations, as calibrateHandEye takes them."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import YAML_BYTES, read_text
from robolaser.data.importers.hand_eye_pairs import MOUNT, Pairs, flange_poses, mount_of, pairs_dataset
from robolaser.data.importers.importer import Imported, Importer, ImportOptions, stated_units, unit_of
from robolaser.data.importers.yaml_file import motion_of_matrix, peek
from robolaser.errors import DataError, near
from robolaser.geometry.rigid_motion import exp_so3, inverse
from robolaser.geometry.units import FACTORS, LENGTH

SUFFIXES = (".yaml", ".yml", ".xml", ".json")
MARKS = ("%YAML:1.0", "%YAML 1.0", "<opencv_storage>", "opencv-matrix")
INVERTED: Final = ("base2gripper", "cam2target")
"""Directions of motions in a list, by OpenCV's words, that give T_base_flange and T_camera_target."""
_NUMBERED = re.compile(r"(.*?)_?(\d+)")


@final
class OpenCVStorage(Importer):
    """Lists with the names of the arguments of `cv2.calibrateHandEye` and `calibrateRobotWorldHandEye`.

    A rotation is a matrix or a Rodrigues vector.
    """

    name = "opencv"
    title = "OpenCV FileStorage with rotations and translations of gripper and target (YAML, XML, JSON)"
    further = (MOUNT,)
    takes = ("units",)

    def recognises(self, path: Path) -> bool:
        """By its suffix and its first bytes."""
        return path.suffix.lower() in SUFFIXES and any(mark in peek(path) for mark in MARKS)

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read one file, or several whose lists belong together."""
        nodes: dict[str, list[Array]] = {}
        for path in paths:
            for key, values in read_storage(path).items():
                if nodes.setdefault(key, values) is not values:
                    raise DataError(f"{path.name}: {key} is in another of the files too.", file=path, column=key)
        file = ", ".join(path.name for path in paths)
        gripper_from, gripper = _motions(nodes, ("gripper2base", "base2gripper"), options, file)
        target_from, target = _motions(nodes, ("target2cam", "world2cam", "cam2target"), options, file)
        if len(gripper) != len(target):
            raise DataError(
                f"{file}: {gripper_from} has {len(gripper)} entries, {target_from} has {len(target)}.", file=file
            )
        mount = mount_of(options, file)
        used = f"{gripper_from}, {target_from}".split(", ")
        left_out = tuple(f"{file}: {key}" for key in nodes if key not in used)
        pairs = Pairs(file, flange_poses(gripper), target, gripper_from, target_from)
        return pairs_dataset(pairs, mount, options, left_out)


def read_storage(path: Path) -> dict[str, list[Array]]:
    """The matrices of each key, in order; `NAME_0`, `NAME_1` and so on are the list NAME."""
    import cv2  # noqa: PLC0415 - slow to import

    text = read_text(path, YAML_BYTES)
    try:
        storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
        root = storage.root()
        found = {key: _arrays(root.getNode(key), path) for key in root.keys()}  # noqa: SIM118 - no mapping
    except (cv2.error, SystemError) as error:
        reason = " ".join(str(error).split())[:200]
        raise DataError(f"{path.name}: OpenCV does not read it: {reason}", file=path) from None
    numbered: dict[str, list[tuple[int, Array]]] = {}
    for key in list(found):
        parts = _NUMBERED.fullmatch(key)
        if parts and len(found[key]) == 1:
            numbered.setdefault(parts[1], []).append((int(parts[2]), found.pop(key)[0]))
    in_order = {name: sorted(entries, key=lambda entry: entry[0]) for name, entries in numbered.items()}
    return {name: [array for _, array in entries] for name, entries in in_order.items()} | found


def _arrays(node: Any, path: Path) -> list[Array]:
    if node.isSeq():
        parts = [node.at(i) for i in range(node.size())]
        if parts and all(map(_is_number, parts)):
            return [np.array([part.real() for part in parts])]
        return [array for part in parts for array in _arrays(part, path)]
    if node.isMap():
        return _matrix(node, path)
    return [np.array([node.real()])] if _is_number(node) else []


def _matrix(node: Any, path: Path) -> list[Array]:
    """The numbers of a matrix, row by row, channels side by side; none where a map is no matrix, or an empty one.

    OpenCV's own reader overwrites memory where a field such as `cols` is missing, which ends the process.
    """
    data = node.getNode("data")
    numbers, sizes = _arrays(data, path), _arrays(node.getNode("rows"), path) or _arrays(node.getNode("sizes"), path)
    if not (data.isSeq() and data.size() and sizes):
        return []
    rows = int(sizes[0][0])
    if len(numbers) != 1 or rows < 1 or numbers[0].size % rows:
        raise DataError(f"{path.name}: the {data.size()} numbers of a matrix do not fill {rows} rows.", file=path)
    return [numbers[0].reshape(rows, -1)]


def _is_number(node: Any) -> bool:
    return bool(node.isReal() or node.isInt())


def _motions(
    nodes: Mapping[str, list[Array]], ways: Sequence[str], options: ImportOptions, file: str
) -> tuple[str, Array]:
    """The motions (n, 4, 4) of the first direction with lists, and these lists' names."""
    way = next((way for way in ways if {f"R_{way}", f"t_{way}"} <= nodes.keys()), None)
    if way is None:
        pairs = ", or ".join(f"R_{way} and t_{way}" for way in ways)
        raise DataError(f"{file} lacks two lists of motions: {pairs}.{near(f'R_{ways[0]}', nodes)}", file=file)
    R, t = f"R_{way}", f"t_{way}"
    turns, shifts = _entries(nodes[R], (9, 3), R, file), _entries(nodes[t], (3,), t, file)
    if len(turns) != len(shifts):
        raise DataError(f"{file}: {R} has {len(turns)} entries, {t} has {len(shifts)}.", file=file)
    T = np.empty((len(turns), 4, 4))
    for i, (turn, shift) in enumerate(zip(turns, shifts, strict=True)):
        matrix = exp_so3(turn) if len(turn) == 3 else turn.reshape(3, 3)
        T[i] = motion_of_matrix(np.column_stack([matrix, shift]), file, f"{R}, entry {i + 1}")
    T[:, :3, 3] *= FACTORS[LENGTH][unit_of(stated_units(options.units), LENGTH, t)]
    return f"{R}, {t}", inverse(T) if way in INVERTED else T


def _entries(arrays: Sequence[Array], sizes: tuple[int, ...], key: str, file: str) -> list[Array]:
    """Matrices or vectors of one of the sizes, flat; a single matrix with many rows is one entry a row."""
    if len(arrays) == 1 and arrays[0].size not in sizes and arrays[0].ndim == 2 and arrays[0].shape[1] in sizes:
        arrays = list(arrays[0])
    flat = [array.reshape(-1) for array in arrays]
    wrong = [i for i, array in enumerate(flat, 1) if array.size != flat[0].size or array.size not in sizes]
    if not flat or wrong or not all(np.isfinite(array).all() for array in flat):
        numbers = " or ".join(map(str, sizes))
        raise DataError(
            f"{file}, {key}: expected a list of entries of {numbers} finite numbers each.", file=file, column=key
        )
    return flat
