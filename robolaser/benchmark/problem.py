"""What contestants are asked: where are the bounds, what does a candidate cost, and what is as good as nothing?"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.forward_model import Model

CALIBRATION, TEST_FUNCTION = "calibration", "test function"
"""Families of questions; only members of one are ranked together."""


@final
@dataclass(frozen=True, eq=False)
class Question:
    """A cost to be minimised within bounds.

    Attributes:
        name: As the user and all results call it.
        title: What it is, for a person.
        family: `CALIBRATION` or `TEST_FUNCTION`.
        variables: Their names, d of them.
        lower: Lower bounds, (d,).
        upper: Upper bounds, (d,).
        cost: Of candidates (c, d) -> (c,); infinite or not a number at poles.
        unit: Of the cost.
        scale: A cost so small that a difference of it can be neglected where the lowest cost is zero, in `unit`.
        residuals: Candidates (c, d) -> (c, r), whose squares add up to the cost; None where it is no sum of squares.
        model: Of a calibration.
        lowest: The lowest cost there is, where theory knows.
    """

    name: str
    title: str
    family: str
    variables: tuple[str, ...]
    lower: Array
    upper: Array
    cost: Callable[[Array], Array]
    unit: str
    scale: float
    residuals: Callable[[Array], Array] | None = None
    model: Model | None = None
    lowest: float | None = None

    def __post_init__(self) -> None:
        """Keep bounds from being written into: one run's mistake would be another's question."""
        for name in ("lower", "upper"):
            bound = np.array(getattr(self, name), np.float64)
            bound.setflags(write=False)
            object.__setattr__(self, name, bound)

    @property
    def dimension(self) -> int:
        """Variables to be found."""
        return len(self.variables)

    def anywhere(self, rng: np.random.Generator, candidates: int = 1) -> Array:
        """Candidates, uniform within the bounds, (candidates, d)."""
        x: Array = rng.uniform(self.lower, self.upper, (candidates, self.dimension))
        return x
