"""What the camera is told of the arm."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array


@final
@dataclass(frozen=True)
class Snapshot:
    """Where the arm went, and how things were at the end of it.

    Attributes:
        path: Joint angles that the encoders saw, one after the other, (j,) each [rad].
        lit: Whether the laser is on.
        now_s: On the controller's clock.
        heard: Commands that the controller heard.
    """

    path: Sequence[Array]
    lit: bool
    now_s: float
    heard: int
