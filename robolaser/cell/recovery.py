"""Whether what an interruption left of a recording is complete and belongs to the cell."""

import csv
import io
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from robolaser.bounded_reading import IMAGE_BYTES, read_bytes, read_text
from robolaser.cell.quantization_noise import KEY, SECTION
from robolaser.cell.route import Waypoint
from robolaser.data.cell_config import Cell
from robolaser.data.toml_schema import read_toml
from robolaser.errors import DataError, unreadable

POSES, IMAGES = "poses.csv", "images"
MERE_WORDS = ("name", "source", "licence")
PNG_BEGINS, PNG_ENDS = b"\x89PNG\r\n\x1a\n", b"IEND\xaeB`\x82"


def check_same_cell(folder: Path, file: str, cell: Cell) -> None:
    """Whether a recording's dataset.toml is its cell's, but for the noise of readings that was put there.

    Args:
        folder: Of the recording.
        file: dataset.toml.
        cell: Where it is to be gone on with.

    Raises:
        DataError: It is not.
    """
    now, then = read_toml(cell.folder / file), read_toml(folder / file)
    if KEY not in now.get(SECTION, {}):
        then.get(SECTION, {}).pop(KEY, None)
    differing = [key for key in {**then, **now} if key not in MERE_WORDS and then.get(key, {}) != now.get(key, {})]
    if differing:
        raise begun_in_another_cell(folder, f"its dataset.toml and the cell's differ in {', '.join(differing)}")


def same(waypoints: Sequence[Waypoint], planned: Sequence[Waypoint]) -> bool:
    """Whether two routes visit the same poses in the same way."""

    def text(route: Sequence[Waypoint]) -> list[tuple[str, list[float]]]:
        return [(name, q.tolist()) for waypoint in route for name, q in waypoint.places]

    return text(waypoints) == text(planned)


def whole_rows(table: Path, columns: Sequence[str]) -> list[dict[str, str]]:
    """Rows of a recording's poses.csv that are whole and whose images are.

    Args:
        table: The file.
        columns: What it would have if it were recorded now.

    Raises:
        DataError: It has other columns, or cannot be read.
    """
    header, rows = _table(table)
    if header is not None and header != set(columns):
        differing = ", ".join(sorted(header ^ set(columns)))
        raise begun_in_another_cell(table.parent, f"its poses.csv and what would be recorded now differ in {differing}")
    found = []
    for cells in rows:
        row = {name: cells[name] for name in columns if isinstance(cells.get(name), str)}
        readings = [row.get(name, "") for name in columns if name == "time_s" or name.startswith("q_")]
        complete = len(row) == len(columns) and all(map(_is_number, readings))
        if complete and all(_is_whole(table.parent / image) for image in _named(row)):
            found.append(row)
    return found


def pictured(folder: Path) -> list[Path]:
    """Images that a recording has taken; none where its poses.csv cannot be read."""
    if not (folder / POSES).is_file():
        return []
    try:
        _, rows = _table(folder / POSES)
    except DataError:
        return []
    names = [Path(name) for row in rows for name in _named(row)]
    images = [folder / IMAGES / name.name for name in names if name.parent == Path(IMAGES)]
    return [image for image in images if image.is_file()]


def _table(path: Path) -> tuple[set[str] | None, list[dict[str | Any, str | Any]]]:
    """Columns, None where their line is torn, and rows as they are."""
    text = read_text(path)
    reader = csv.DictReader(io.StringIO(text, newline=""))
    try:
        return set(reader.fieldnames or ()) if "\n" in text else None, list(reader)
    except csv.Error as error:
        raise unreadable(path, str(error)) from None


def _is_whole(image: Path) -> bool:
    """Whether a PNG file is there from its first byte to its last."""
    try:
        data = read_bytes(image, IMAGE_BYTES)
    except DataError:
        return False
    return data.startswith(PNG_BEGINS) and data.endswith(PNG_ENDS)


def _named(row: Mapping[str | Any, object]) -> list[str]:
    """Images that a row of poses.csv names."""
    return [
        value for name, value in row.items() if name and name.startswith("image") and value and isinstance(value, str)
    ]


def _is_number(cell: str) -> bool:
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False


def begun_in_another_cell(folder: Path, what: str) -> DataError:
    """The error of a recording that does not fit the cell."""
    return DataError(
        f"{folder} was begun in another cell: {what}. Continue with the cell as it was, or choose another --output.",
        file=folder,
    )
