"""Images of a board with the arm's readings, as a raw recording of a camera; a folder of them and a table of poses."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Final, final, get_args

from robolaser.bounded_reading import IMAGE_BYTES, decoded, read_bytes
from robolaser.data.board import Board, Printed
from robolaser.data.csv_tables import CsvTable, bad_row, finite
from robolaser.data.data_tables import poses_of
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.importers.column_choice import POSES, TEXT, choose, pose_quantities, with_quaternions
from robolaser.data.importers.hand_eye_pairs import MOUNT, mount_of
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.table_files import TABLE_SUFFIXES, read_any_table
from robolaser.data.result_folder import Contents, written_later
from robolaser.data.sensor_format import Mount, sensor_format
from robolaser.errors import DataError, UsageError, near
from robolaser.geometry.units import FACTORS, LENGTH

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".webp")
BOARD: Final = "board"  # option that describes the board's print
FORM = "--set board=checkerboard,7x6,10mm or --set board=charuco,4x6,36mm,18mm,DICT_6X6_250 (inner corners in x and y)"
DIGITS = 12  # 36 mm are 0.036 m, not 0.036000000000000004
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
    """The board by `--set board=KIND,COLUMNSxROWS,SQUARE[,MARKER,DICTIONARY]`."""
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
    """Images of poses on disk, None where there is none, under their names in the data set's folder `images`.

    Returns:
        The path of each pose's image in the data set, "" where there is none; the contents, by path; and the width
        and height of all [px].
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
            message = f"{file.name} has {here[0]} x {here[1]} pixels, but the image before it {size[0]} x {size[1]}."
            raise DataError(message, file=file)
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


IMAGE: Final = "image"
CAL_DATA: Final = "cal_data.yaml"  # of industrial_calibration, which has a folder of images too


@final
class ImageFolder(Importer):
    """A folder with images and one table, or the folder of images and then the table.

    A row of the table is a pose: joint readings, with a robot, or a flange pose. Its column `image` names the file.
    """

    name = "images"
    title = "a folder of images of a board, and a table with the arm's pose at each"
    further = (MOUNT, BOARD)
    takes = (
        "robot", "columns", "units", "units_of_file", "separator", "decimal", "header_row", "euler",
    )  # fmt: skip

    def recognises(self, path: Path) -> bool:
        """A folder with images and one table."""
        return path.is_dir() and not (path / CAL_DATA).exists() and bool(_images(path)) and len(_tables(path)) == 1

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read the table and check every image."""
        if len(paths) > 2 or not paths[0].is_dir() or (len(paths) == 1 and len(_tables(paths[0])) != 1):
            raise UsageError("Name a folder with images and one table, or the folder of images and then the table.")
        folder, file = paths[0], paths[1] if len(paths) == 2 else _tables(paths[0])[0]
        table = read_any_table(file, options)
        mount, board = mount_of(options, file.name), board_of(options.further, file.name)
        columns, left_out = choose({POSES: table}, {POSES: {**pose_quantities(options), IMAGE: TEXT}}, options)
        of_poses = dict(columns[POSES].chosen)
        named = of_poses.pop(IMAGE, None)
        if named is None:
            raise UsageError(f"{file.name}: which image belongs to each row? Name the column with --column image=NAME.")
        poses_table, read_from = replace(columns[POSES], chosen=of_poses).read(number_poses=True)
        read, warnings = poses_of(with_quaternions(poses_table, options.euler), Path(), options.robot)
        files = _files(table, named, folder)
        images, contents, size_px = image_files(files)
        dataset = camera_recording(replace(read, image=images), size_px, board, mount, options, source=file.name)
        spare = sorted({image.name for image in _images(folder)} - {one.name for one in files if one is not None})
        left_out = (*left_out, *(f"{name}: no row names it" for name in spare))
        return Imported(
            replace(dataset, warnings=tuple(warnings)), {"poses.csv": {**read_from, IMAGE: named}}, left_out, contents
        )


def _files(table: CsvTable, column: str, folder: Path) -> list[Path | None]:
    known: dict[str, list[Path]] = {}
    for image in _images(folder):
        known.setdefault(image.name, []).append(image)
    files: list[Path | None] = []
    for line, cell in zip(table.lines, table.cells(column), strict=True):
        stated = PurePosixPath(PureWindowsPath(cell).as_posix())  # tables are written on Windows, too
        name = stated.name
        if cell and name not in known:
            raise bad_row(table.file, line, f"no image {name} in {folder.name}.{near(name, known, 5)}", column)
        there = [image for image in known.get(name, ()) if image.as_posix().endswith(f"/{stated}")]
        there = there or known.get(name, [])
        if cell and len(there) > 1:
            folders = ", ".join(sorted(image.parent.name for image in there))
            raise bad_row(table.file, line, f"{cell} is in several folders ({folders}). Write FOLDER/{name}.", column)
        files.append(there[0] if cell else None)
    return files


def _images(folder: Path) -> list[Path]:
    """The images of a folder and its subfolders."""
    return sorted(path for path in (*folder.iterdir(), *folder.glob("*/*")) if path.suffix.lower() in SUFFIXES)


def _tables(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in TABLE_SUFFIXES)
