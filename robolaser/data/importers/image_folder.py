"""A folder of images of a board and a table with the arm's pose at each of them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import ClassVar, Final, final

from robolaser.data.csv_tables import CsvTable, bad_row
from robolaser.data.data_tables import poses_of
from robolaser.data.importers.camera_recording import BOARD, SUFFIXES, board_of, camera_recording, image_files
from robolaser.data.importers.column_choice import POSES, TEXT, choose, pose_quantities, with_quaternions
from robolaser.data.importers.hand_eye_pairs import MOUNT, mount_of
from robolaser.data.importers.importer import Imported, Importer, ImportOptions
from robolaser.data.importers.industrial_calibration import FILE as CAL_DATA
from robolaser.data.importers.table_files import TABLE_SUFFIXES, read_any_table
from robolaser.errors import UsageError, near

IMAGE: Final = "image"


@final
class ImageFolder(Importer):
    """A folder with images and one table, or the folder of images and then the table.

    A row of the table is a pose: joint readings, with a robot, or a flange pose. Its column `image` names the file.
    """

    name: ClassVar[str] = "images"
    title: ClassVar[str] = "a folder of images of a board, and a table with the arm's pose at each"
    further: ClassVar[tuple[str, ...]] = (MOUNT, BOARD)
    takes: ClassVar[tuple[str, ...]] = ("robot", "columns", "units", "separator", "decimal", "header_row", "euler")

    def recognises(self, path: Path) -> bool:
        """A folder with images and one table."""
        return path.is_dir() and not (path / CAL_DATA).exists() and bool(_images(path)) and len(_tables(path)) == 1

    def read(self, paths: Sequence[Path], options: ImportOptions) -> Imported:
        """Read the table, and see that every image is one."""
        if len(paths) > 2 or not paths[0].is_dir() or (len(paths) == 1 and len(_tables(paths[0])) != 1):
            raise UsageError("Name a folder with images and one table, or the folder of images and then the table.")
        folder, file = paths[0], paths[1] if len(paths) == 2 else _tables(paths[0])[0]
        table = read_any_table(file, options)
        mount, board = mount_of(options, file.name), board_of(options.further, file.name)
        known = {**pose_quantities(options), IMAGE: TEXT}
        columns, left_out = choose({POSES: table}, {POSES: known}, options)
        of_poses = dict(columns[POSES].chosen)
        named = of_poses.pop(IMAGE, None)
        if named is None:
            raise UsageError(f"{file.name}: which image belongs to each row? Name the column with --column image=NAME.")
        poses_table, read_from = replace(columns[POSES], chosen=of_poses).read(number_poses=True)
        read, warnings = poses_of(with_quaternions(poses_table, options.euler), Path(), options.robot)
        files = _files(table, named, folder)
        images, contents, size_px = image_files(files)
        poses = replace(read, image=images)
        dataset = camera_recording(poses, size_px, board, mount, options, source=file.name)
        spare = sorted({image.name for image in _images(folder)} - {one.name for one in files if one is not None})
        left_out = (*left_out, *(f"{name}: no row names it" for name in spare))
        return Imported(
            replace(dataset, warnings=tuple(warnings)), {"poses.csv": {**read_from, IMAGE: named}}, left_out, contents
        )


def _files(table: CsvTable, column: str, folder: Path) -> list[Path | None]:
    """The image of each row."""
    known: dict[str, list[Path]] = {}
    for image in _images(folder):
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
    return files


def _images(folder: Path) -> list[Path]:
    """The images of a folder and of those in it."""
    return sorted(path for path in (*folder.iterdir(), *folder.glob("*/*")) if path.suffix.lower() in SUFFIXES)


def _tables(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.suffix.lower() in TABLE_SUFFIXES)
