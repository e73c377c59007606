"""What was imported, checked by reading it back, and only then written where it belongs."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

from robolaser.data.atomic_write import write_bytes
from robolaser.data.dataset import Dataset
from robolaser.data.dataset_file import FILE
from robolaser.data.importers.importer import Imported
from robolaser.data.loading import load
from robolaser.data.writing import FOLDER, point_columns, pose_columns, save
from robolaser.errors import OutputError, UsageError, output_exists, unwritable

ROWS_SHOWN = 3


def check_output(folder: Path, sources: Iterable[Path], *, overwrite: bool) -> None:
    """See that a data set can be written to a folder without loss.

    Args:
        folder: Where it should go.
        sources: Files and folders that it is read from.
        overwrite: Whether a data set that is there may be replaced.

    Raises:
        UsageError: A source lies in the folder, or the folder in a source.
        OutputError: There is a data set and it may not be replaced, or files of that name that are none.
    """
    for source in sources:
        if folder.resolve() in (source.resolve(), *source.resolve().parents):
            raise UsageError(f"--output {folder} holds {source.name}, which is read: choose a folder of its own.")
        if source.is_dir() and folder.resolve().is_relative_to(source.resolve()):
            raise UsageError(f"--output {folder} lies in {source.name}, which is read: choose a folder beside it.")
    there = [folder / name for name in FOLDER if (folder / name).exists()]
    if there and not overwrite:
        raise output_exists(there[0])
    if there and not (folder / FILE).exists():
        raise OutputError(f"{there[0]} is there, but no data set that could be replaced. Choose another --output.")


def checked(imported: Imported) -> Dataset:
    """The data set as `load` reads it back.

    Raises:
        DataError: It is not what the format asks for.
    """
    with TemporaryDirectory() as folder:
        save(imported.dataset, folder)
        return load(folder)


def write(imported: Imported, folder: Path, *, overwrite: bool) -> None:
    """Write a data set with its images; the tables come last, so that a folder that was cut off is no data set.

    Raises:
        OutputError: The disk or the rights say no.
    """
    for path, contents in imported.images.items():
        try:
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise unwritable(folder / path, error.strerror or str(error)) from None
        write_bytes(folder / path, contents())
    save(imported.dataset, folder, overwrite=overwrite)


def preview(imported: Imported, rows: int = ROWS_SHOWN) -> Mapping[str, Mapping[str, Sequence[str]]]:
    """The first cells of each column as they will be written, by table and column."""
    tables = {"poses.csv": pose_columns}
    if len(imported.dataset.points):
        tables["points.csv"] = point_columns
    return {
        name: {column: list(islice(cells, rows)) for column, cells in columns(imported.dataset)}
        for name, columns in tables.items()
    }
