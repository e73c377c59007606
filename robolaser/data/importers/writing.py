"""What was imported, checked by reading it back, and only then written where it belongs."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

from robolaser.data.atomic_write import written_later
from robolaser.data.dataset import Dataset
from robolaser.data.importers.importer import Imported
from robolaser.data.loading import load
from robolaser.data.result_folder import write_results
from robolaser.data.writing import point_columns, pose_columns, save, texts_of
from robolaser.errors import UsageError

ROWS_SHOWN = 3


def check_apart(folder: Path, sources: Iterable[Path]) -> None:
    """See that a data set is not written beside or into what it is read from.

    Raises:
        UsageError: A source lies in the folder, or the folder in a source.
    """
    for source in sources:
        if folder.resolve() in (source.resolve(), *source.resolve().parents):
            raise UsageError(f"--output {folder} holds {source.name}, which is read: choose a folder of its own.")
        if source.is_dir() and folder.resolve().is_relative_to(source.resolve()):
            raise UsageError(f"--output {folder} lies in {source.name}, which is read: choose a folder beside it.")


def checked(imported: Imported) -> Dataset:
    """The data set as `load` reads it back.

    Raises:
        DataError: It is not what the format asks for.
    """
    with TemporaryDirectory() as folder:
        save(imported.dataset, folder)
        return load(folder)


def write(imported: Imported, folder: Path) -> None:
    """Write a data set with its images, whole or not at all.

    Raises:
        OutputError: The disk or the rights say no.
    """
    images = {name: written_later(read) for name, read in imported.images.items()}
    write_results(folder, {**images, **texts_of(imported.dataset)})


def preview(imported: Imported) -> Mapping[str, Mapping[str, Sequence[str]]]:
    """The first cells of each column as they will be written, by table and column."""
    tables = {"poses.csv": pose_columns}
    if len(imported.dataset.points):
        tables["points.csv"] = point_columns
    return {
        name: {column: list(islice(cells, ROWS_SHOWN)) for column, cells in columns(imported.dataset)}
        for name, columns in tables.items()
    }
