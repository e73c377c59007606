"""What is said of a problem: its name, its kind, and the best that is known of it."""

from dataclasses import dataclass
from typing import Any, final

import numpy as np

CALIBRATION, TEST_FUNCTION, OWN, SEVERAL = "calibration", "test function", "own problem", "several objectives"
"""Families of problems; only problems of one family are ranked together."""
THEORY, OUR_OWN = "theory", "robolaser's own search"
"""Who found the lowest cost, where no run did."""


@final
@dataclass(frozen=True)
class ProblemSummary:
    """A problem, and the best that is known of it."""

    name: str
    title: str  # a description for a person
    family: str
    dimension: int
    objectives: int
    unit: str = ""  # of the cost
    budget: int = 0  # evaluations of a run
    noisy: bool = False  # runs are ranked by what they returned, evaluated anew
    floor: float | None = None  # where the cost has a natural zero: what can be neglected; targets are relative then
    lowest: float | None = None  # the lowest cost, where it is known before any run
    front: Any = None  # the best front, where theory knows it, rows of objectives
    found_by: str = ""  # a solver's name, or `THEORY`, `OUR_OWN` or, of fronts, all runs together
    best: float = np.inf  # the lowest cost known; of several objectives IGD+ of the best front, 0
    fingerprint: str = ""

    @property
    def scale(self) -> float:
        """Unit of the targets' tolerances: the lowest cost itself where its zero means something, else 1."""
        return 1.0 if self.floor is None else max(abs(self.best), self.floor)

    def target(self, tolerance: float) -> float:
        """The cost to be reached."""
        return self.best + tolerance * self.scale
