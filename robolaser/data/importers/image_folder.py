"""A folder of images of a board and a table with the arm's pose at each of them."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import ClassVar, Final, final

from robolaser.data.csv_tables import CsvTable, bad_row
from robolaser.data.dataset import Poses
from robolaser.data.importers.board_option import BOARD, board_of
from robolaser.data.importers.camera_recording import SUFFIXES, camera_recording, image_files
from robolaser.data.importers.column_choice import POSES, TEXT, choose, pose_quantities
from robolaser.data.importers.column_reader import ColumnReader, with_quaternions
from robolaser.data.importers.delimited_text import read_delimited
from robolaser.data.importers.hand_eye_pairs import MOUNT, mount_of
from robolaser.data.importers.importer import Imported, Importer, ImportOptions, Reading
from robolaser.data.importers.industrial_calibration import FILE as CAL_DATA
from robolaser.data.importers.intrinsics import HOLD, INTRINSICS, intrinsic_parameters, intrinsics_of_file
from robolaser.data.importers.tables import SUFFIXES as TABLES
from robolaser.data.pose_table import poses_of
from robolaser.errors import DataError, UsageError, near

IMAGE: Final = "image"
ORDER: Final = "order"  # option that says that images belong to rows in the order of their names


@final
class ImageFolder(Importer):
    """A folder with images and one table, or the folder of images and then the table.

    A row of the table is a pose: joint readings, with a robot, or a flange pose. Its column `image` names the file; or
    `--set order=sorted` says that the images belong to the rows in the order of their names, numbers as numbers.
    """

    name: ClassVar[str] = "images"
    title: ClassVar[str] = "a folder of images of a board, and a table with the arm's pose at each"
    further: ClassVar[tuple[str, ...]] = (MOUNT, BOARD, ORDER, INTRINSICS, HOLD)
    takes: ClassVar[tuple[str, ...]] = ("robot", "columns", "units", "separator", "decimal", "header_row", "euler")

    def recognises(self, path: Path) -> bool:
        """A folder with images and one table."""
        return path.is_dir() and not (path / CAL_DATA).exists() and bool(_images(path)) and len(_tables(path)) == 1

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read the table, and see that every image is one."""
        for path in paths:
            if not path.exists():
                raise DataError(f"Cannot read {path}: no such file or folder.", file=path)
        if len(paths) > 2 or not paths[0].is_dir() or (len(paths) == 1 and len(_tables(paths[0])) != 1):
            raise UsageError("Name a folder with images and one table, or the folder of images and then the table.")
        folder, file = paths[0], paths[1] if len(paths) == 2 else _tables(paths[0])[0]
        table = read_delimited(file, options)
        mount, board = mount_of(options, file.name), board_of(options.further)
        known = {**pose_quantities(options), IMAGE: TEXT}
        choice = choose({POSES: table}, {POSES: known}, options)
        of_poses = {column: source for column, source in choice.poses.items() if column != IMAGE}
        reader = ColumnReader(POSES, table, of_poses, known, options)
        read, warnings = poses_of(
            with_quaternions(reader.table(number_poses=True), options.euler), Path(), options.robot
        )
        files, words = _files(table, choice.poses.get(IMAGE), folder, options)
        found = image_files(files)
        poses: Poses = replace(read, image=found.paths)
        stated = options.further.get(INTRINSICS)
        if stated is None and HOLD in options.further:
            raise UsageError(f"--set {HOLD}: which values? Name their file with --set {INTRINSICS}=FILE.")
        parameters = {} if stated is None else intrinsic_parameters(intrinsics_of_file(Path(stated)), options.further)
        dataset = camera_recording(
            poses, found, board, mount, options, source=file.name, parameters=parameters, robot=options.robot
        )
        readings = [*reader.readings(number_poses=True), Reading("poses.csv", IMAGE, file.name, words)]
        if stated is not None:
            readings.append(Reading("dataset.toml", " ".join(parameters), Path(stated).name, "intrinsics", "px"))
        spare = sorted({image.name for image in _images(folder)} - {one.name for one in files if one is not None})
        left_out = (*choice.left_out, *(f"{name}: no row names it" for name in spare))
        return Imported(replace(dataset, warnings=tuple(warnings)), tuple(readings), left_out, found.contents)


def _files(table: CsvTable, column: str | None, folder: Path, options: ImportOptions) -> tuple[list[Path | None], str]:
    """The image of each row, and what it is read from."""
    images = _images(folder)
    if column is None:
        if options.further.get(ORDER) != "sorted":
            raise UsageError(
                f"{table.file}: which image belongs to which row? Name the column with --column image=NAME or, if they"
                f" follow each other in the order of their names, say --set {ORDER}=sorted."
            )
        if len(images) != len(table):
            raise DataError(
                f"{table.file} has {len(table)} rows, but {folder.name} has {len(images)} images.", file=folder
            )
        return list(images), "(order of the names)"
    if ORDER in options.further:
        raise UsageError(f"--set {ORDER}: the column {column} names the images. Leave one of them out.")
    known: dict[str, list[Path]] = {}
    for image in images:
        known.setdefault(image.name, []).append(image)
    files: list[Path | None] = []
    for line, cell in zip(table.lines, table.cells(column), strict=True):
        name = Path(cell).name
        if cell and name not in known:
            raise bad_row(table.file, line, f"no image {name} in {folder.name}.{near(name, known, 5)}", column)
        there = [image for image in known.get(name, ()) if image.as_posix().endswith(f"/{PurePosixPath(cell)}")]
        there = there or known.get(name, [])
        if cell and len(there) > 1:
            folders = ", ".join(sorted(image.parent.name for image in there))
            where = f"{cell} is in several folders ({folders}). Write FOLDER/{name}."
            raise bad_row(table.file, line, where, column)
        files.append(there[0] if cell else None)
    return files, column


def _images(folder: Path) -> list[Path]:
    """The images of a folder and of those in it, those with numbers in their names by the numbers."""
    found = [path for path in (*folder.iterdir(), *folder.glob("*/*")) if path.suffix.lower() in SUFFIXES]

    def numbered(path: Path) -> list[tuple[bool, str]]:
        parts = re.findall(r"\d+|\D+", f"{path.parent.name}/{path.stem}")
        return [(not part.isdigit(), part.zfill(20)) for part in parts]

    return sorted(found, key=numbered)


def _tables(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in TABLES)
