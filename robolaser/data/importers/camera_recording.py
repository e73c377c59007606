"""Images of a board with the arm's readings, as a raw recording of a camera: `extract` finds the board in them."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Final, get_args

from robolaser.bounded_reading import IMAGE_BYTES, decoded, read_bytes
from robolaser.data.atomic_write import Contents, written_later
from robolaser.data.board import Board, Printed
from robolaser.data.csv_tables import finite
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.importers.importer import ImportOptions
from robolaser.data.sensor_format import Mount, sensor_format
from robolaser.errors import DataError, UsageError, near
from robolaser.geometry.units import FACTORS, LENGTH

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".webp")
BOARD: Final = "board"  # option that says what is printed on the board
FORM = "--set board=checkerboard,7x6,10mm or --set board=charuco,4x6,36mm,18mm,DICT_6X6_250 (inner corners in x and y)"
DIGITS = 12  # 36 mm are 0.036 m, and not 0.036000000000000004
_LENGTH = re.compile(r"(?P<number>[0-9.eE+-]+)(?P<unit>[a-z]+)")


def camera_recording(
    poses: Poses, size_px: tuple[int, int], board: Board, mount: Mount, options: ImportOptions, *, source: str
) -> Dataset:
    """The recording, without points; `poses` have the paths of the images, `size_px` is their width and height."""
    declared = sensor_format("camera")
    assert declared.options is not None  # where it is mounted
    return Dataset(
        options.name,
        poses,
        kind="camera",
        robot=options.robot,
        options=declared.options(mount=mount),
        image_px=size_px,
        board=board,
        placed=False,
        path_known=options.path_known,
        source=source,
    )


def board_of(further: Mapping[str, str], file: str) -> Board:
    """The board that `--set board=KIND,COLUMNSxROWS,SQUARE[,MARKER,DICTIONARY]` states.

    Raises:
        UsageError: None is stated, or it is no board.
    """
    stated = further.get(BOARD)
    if stated is None:
        raise UsageError(f"{file}: what is printed on the board? State it with {FORM}.")
    kind, *rest = (part.strip() for part in stated.split(","))
    kinds = get_args(Printed)
    if kind not in kinds:
        raise UsageError(f"--set board={stated}: no board of kind '{kind}'.{near(kind, kinds)} Write {FORM}.")
    counts = re.fullmatch(r"(\d{1,4})x(\d{1,4})", rest[0]) if rest else None
    if counts is None or len(rest) != (4 if kind == "charuco" else 2):
        raise UsageError(f"--set board={stated}: expected {FORM}.")
    square, *markers = rest[1:]
    return Board(
        columns=int(counts[1]),
        rows=int(counts[2]),
        square_m=_metres(square, stated),
        kind=kind,  # type: ignore[arg-type]
        marker_m=_metres(markers[0], stated) if markers else None,
        dictionary=markers[1] if markers else None,
    )


def _metres(text: str, stated: str) -> float:
    found = _LENGTH.fullmatch(text)
    factor = FACTORS[LENGTH].get(found["unit"]) if found else None
    value = round(finite(found["number"]) * factor, DIGITS) if found and factor else 0.0
    if not 0 < value < 100:
        raise UsageError(f"--set board={stated}: {text} is no length with a unit, such as 10mm or 0.01m.")
    return value


def image_files(files: Sequence[Path | None]) -> tuple[tuple[str, ...], dict[str, Contents], tuple[int, int]]:
    """Images on disk, under their own names in the data set's folder `images`.

    Args:
        files: Of each pose; None where there is none.

    Returns:
        The path of each pose's image in the data set, "" where there is none; what each holds, by path; and the width
        and height of all [px].

    Raises:
        DataError: One cannot be read, has another size than the first, or shares its name with another; there is none.
    """
    origin: dict[str, Path] = {}
    paths = []
    size: tuple[int, int] | None = None
    for file in files:
        paths.append("" if file is None else str(PurePosixPath("images") / file.name))
        if file is None or origin.get(paths[-1]) == file:
            continue
        if origin.setdefault(paths[-1], file) != file:
            raise DataError(f"{origin[paths[-1]]} and {file} have the same name: rename one.", file=file)
        here = _size(file)
        size = size or here
        if here != size:
            said = f"{file.name} has {here[0]} x {here[1]} pixels, but the image before it {size[0]} x {size[1]}."
            raise DataError(said, file=file)
    if size is None:
        raise DataError("There is no image.")
    return tuple(paths), {path: written_later(file.read_bytes) for path, file in origin.items()}, size


def _size(file: Path) -> tuple[int, int]:
    import cv2  # noqa: PLC0415 - slow to import

    image = decoded(read_bytes(file, IMAGE_BYTES), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise DataError(f"{file.name} is not an image that OpenCV can read. Is it complete?", file=file)
    height, width = image.shape[:2]
    return width, height
