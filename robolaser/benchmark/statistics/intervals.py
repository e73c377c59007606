"""Numbers that runs estimate, and the bounds of what they could be as well."""

from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array

CONFIDENCE = 0.95
"""Level of every interval."""


@final
@dataclass(frozen=True, eq=False)
class Intervals:
    """Estimates, and the intervals that hold the truth with `CONFIDENCE`; all of one shape.

    Attributes:
        value: NaN where there is none, infinite where no run reached a target.
        lower: NaN where there are too few runs to say.
        upper: NaN where there are too few runs to say, infinite where they leave it open.
    """

    value: Array
    lower: Array
    upper: Array
