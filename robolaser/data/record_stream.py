"""Files of many records of one kind, written as they come: their number stands at the head, and is known at the end."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from robolaser.data.atomic_write import write_together


def write_streamed(path: Path, head: Callable[[int], bytes], pieces: Iterable[NDArray[Any]]) -> int:
    """Write records, whole or not at all.

    Args:
        path: The file; what was there stays until all is written.
        head: Gives what stands before so many records; as long for one number as for any other.
        pieces: Records in order, each (n,).

    Returns:
        How many records were written.

    Raises:
        OutputError: The disk or its rights refuse.
    """
    count = 0

    def write(file: BinaryIO) -> None:
        nonlocal count
        file.write(head(0))
        for piece in pieces:
            file.write(np.ascontiguousarray(piece).data.cast("B"))
            count += len(piece)
        file.seek(0)
        file.write(head(count))

    write_together(path.parent, {path.name: write})
    return count
