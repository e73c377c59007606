"""What an earlier day has left of a recording, and whether it is whole."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

from robolaser.cell.quantization_noise import KEY, SECTION
from robolaser.cell.route import Visit
from robolaser.data.cell_config import Cell
from robolaser.data.toml_schema import read_toml
from robolaser.errors import CellDiffers

MERE_WORDS = ("name", "source", "licence")
PNG_BEGINS, PNG_ENDS = b"\x89PNG\r\n\x1a\n", b"IEND\xaeB`\x82"


def see_same_cell(folder: Path, file: str, cell: Cell) -> None:
    """Whether a recording's dataset.toml is its cell's, but for the noise of readings that was put there.

    Args:
        folder: Of the recording.
        file: dataset.toml.
        cell: Where it is to be gone on with.

    Raises:
        CellDiffers: It is not.
    """
    now, then = read_toml(cell.folder / file), read_toml(folder / file)
    if KEY not in now.get(SECTION, {}):
        then.get(SECTION, {}).pop(KEY, None)
    differing = [key for key in {**then, **now} if key not in MERE_WORDS and then.get(key, {}) != now.get(key, {})]
    if differing:
        raise CellDiffers(folder, f"its dataset.toml and the cell's differ in {', '.join(differing)}")


def same(visits: Sequence[Visit], planned: Sequence[Visit]) -> bool:
    """Whether two routes visit the same poses in the same way."""

    def text(visit: Visit) -> tuple[object, ...]:
        return visit.name, visit.q.tolist(), None if visit.approach is None else visit.approach.tolist()

    return [text(visit) for visit in visits] == [text(visit) for visit in planned]


def whole(image: Path) -> bool:
    """Whether a PNG file is there from its first byte to its last."""
    try:
        data = image.read_bytes()
    except OSError:
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
