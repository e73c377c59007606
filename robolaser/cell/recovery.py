"""What an interruption left of a recording, and whether it belongs to the cell and the plan."""

from collections.abc import Sequence
from pathlib import Path

from robolaser.bounded_reading import IMAGE_BYTES, read_bytes
from robolaser.cell.quantization_noise import KEY, SECTION
from robolaser.data.cell_config import Cell
from robolaser.data.csv_tables import read_table
from robolaser.data.toml_schema import read_toml
from robolaser.errors import DataError, PlanError

POSES = "poses.csv"
MERE_WORDS = ("name", "source", "licence")
PNG_BEGINS, PNG_ENDS = b"\x89PNG\r\n\x1a\n", b"IEND\xaeB`\x82"


def check_same_cell(file: Path, cell: Cell) -> None:
    """See that a recording's dataset.toml is its cell's, but for the noise of readings that was put there.

    Raises:
        DataError: It is not.
    """
    now, then = read_toml(cell.folder / file.name), read_toml(file)
    if KEY not in now.get(SECTION, {}):
        then.get(SECTION, {}).pop(KEY, None)
    differing = [key for key in {**then, **now} if key not in MERE_WORDS and then.get(key, {}) != now.get(key, {})]
    if differing:
        raise _another_cell(file.parent, f"its dataset.toml and the cell's differ in {', '.join(differing)}")


def recorded_rows(table: Path, columns: Sequence[str]) -> list[dict[str, str]]:
    """Rows of a recording's poses.csv whose images are whole; it should have the columns that it would have now.

    Raises:
        DataError: It has other columns, or a time or a reading is no number; with row and column.
    """
    read = read_table(table)
    differing = sorted(read.columns.keys() ^ set(columns))
    if differing:
        raise _another_cell(
            table.parent, f"its poses.csv and what would be recorded now differ in {', '.join(differing)}"
        )
    read.numbers([name for name in columns if name == "time_s" or name.startswith("q_")])
    rows = [
        dict(zip(columns, cells, strict=True)) for cells in zip(*(read.cells(name) for name in columns), strict=True)
    ]
    images = [[cell for name, cell in row.items() if name.startswith("image") and cell] for row in rows]
    return [row for row, own in zip(rows, images, strict=True) if all(_is_whole(table.parent / one) for one in own)]


def pictured(folder: Path) -> list[str]:
    """Names of the images that a recording has taken; none where its poses.csv cannot be read."""
    try:
        read = read_table(folder / POSES)
    except DataError:
        return []
    names = [name for column in read.columns if column.startswith("image") for name in read.cells(column)]
    return [name for name in names if name.startswith("images/") and ".." not in name and (folder / name).is_file()]


def another_plan(folder: Path, what: str) -> PlanError:
    """The error of a recording that was begun with other poses."""
    return PlanError(
        f"{folder} was begun with another plan: {what}. Continue with --resume alone, which keeps to that plan,"
        " or choose another --output."
    )


def _is_whole(image: Path) -> bool:
    """Whether a PNG file is there from its first byte to its last."""
    try:
        data = read_bytes(image, IMAGE_BYTES)
    except DataError:
        return False
    return data.startswith(PNG_BEGINS) and data.endswith(PNG_ENDS)


def _another_cell(folder: Path, what: str) -> DataError:
    return DataError(
        f"{folder} was begun in another cell: {what}. Continue with the cell as it was, or choose another --output.",
        file=folder,
    )
