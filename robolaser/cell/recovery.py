"""Whether what an interruption left of a recording is complete and belongs to the cell."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from robolaser.bounded_reading import IMAGE_BYTES, read_bytes
from robolaser.cell.quantization_noise import KEY, SECTION
from robolaser.cell.route import Waypoint
from robolaser.data.cell_config import Cell
from robolaser.data.toml_schema import read_toml
from robolaser.errors import DataError

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

    def text(waypoint: Waypoint) -> tuple[object, ...]:
        return waypoint.name, waypoint.q.tolist(), None if waypoint.approach is None else waypoint.approach.tolist()

    return [text(waypoint) for waypoint in waypoints] == [text(waypoint) for waypoint in planned]


def whole(image: Path) -> bool:
    """Whether a PNG file is there from its first byte to its last."""
    try:
        data = read_bytes(image, IMAGE_BYTES)
    except DataError:
        return False
    return data.startswith(PNG_BEGINS) and data.endswith(PNG_ENDS)


def named(row: Mapping[str | None, object]) -> list[str]:
    """Images that a row of poses.csv names."""
    return [value for name, value in row.items() if name and name.startswith("image") and isinstance(value, str)]


def is_number(cell: str) -> bool:
    """Whether a cell of a table holds a finite number."""
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
