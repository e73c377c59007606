"""A cost that solvers minimise: its bounds, its residuals where it has any, and what difference can be neglected."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, final

import numpy as np

from robolaser.arrays import Array

if TYPE_CHECKING:
    from robolaser.benchmark.front import Front
    from robolaser.model.forward_model import Model

CALIBRATION, TEST_FUNCTION, OWN = "calibration", "test function", "own problem"
"""Families of problems; only problems of one family are ranked together."""
INFEASIBLE = 1e30
"""A candidate that violates constraints costs so many times (1 + its violation): feasibility first, after Deb 2000."""
PROBES, PROBE_SEED = 8, 1
"""Random candidates whose costs say what a problem is like."""


@final
@dataclass(frozen=True, eq=False)
class BenchmarkProblem:
    """A cost to be minimised within bounds.

    Attributes:
        name: The user's name for it, and that of all results.
        title: A description for a person.
        family: `CALIBRATION`, `TEST_FUNCTION` or `OWN`.
        variables: Their names, d of them.
        lower: Lower bounds, (d,).
        upper: Upper bounds, (d,).
        cost: Of candidates (c, d) -> (c,), of several objectives (c, m); infinite or not a number at poles.
        unit: Of the cost.
        scale: A difference in cost that can be neglected where the lowest cost is zero, in `unit`.
        residuals: Candidates (c, d) -> (c, r), whose squares add up to the cost; None if it is not a sum of squares.
        model: The forward model of a calibration.
        lowest: The lowest cost, where theory knows it.
        constraints: Their number; with any, costs from `INFEASIBLE` on are those of infeasible candidates.
        front: An empty one, if the problem has several objectives.
        starts: Candidates that every solver begins with, the best first, (k, d); none by default.
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
    model: "Model | None" = None
    lowest: float | None = None
    constraints: int = 0
    front: "Front | None" = None
    starts: Array = field(default_factory=lambda: np.empty((0, 0)))

    def __post_init__(self) -> None:
        """Make the bounds read-only: what one run wrote into them would change the problem of the next."""
        for name in ("lower", "upper", "starts"):
            bound = np.array(getattr(self, name), np.float64)
            bound.setflags(write=False)
            object.__setattr__(self, name, bound)

    @property
    def dimension(self) -> int:
        """Number of variables."""
        return len(self.variables)

    def sample_uniform(self, rng: np.random.Generator, candidates: int = 1) -> Array:
        """Candidates, uniform within the bounds, (candidates, d)."""
        x: Array = rng.uniform(self.lower, self.upper, (candidates, self.dimension))
        return x


@final
@dataclass(frozen=True, eq=False)
class ProblemSpec:
    """Builds a problem; unlike the problem, whose functions cannot be pickled, it can be sent to another process."""

    name: str
    problem: Callable[[], BenchmarkProblem]


@final
@dataclass(frozen=True)
class ProblemSummary:
    """A problem, and the lowest cost that was ever found.

    Attributes:
        name: Name of the problem.
        title: A description for a person.
        family: See `BenchmarkProblem`.
        dimension: Number of variables.
        unit: Of the cost.
        scale: Unit of the targets' tolerances: the lowest cost itself, unless it is close to zero.
        best: The lowest cost known.
        found_by: A solver's name, "theory", or "robolaser's own search".
    """

    name: str
    title: str
    family: str
    dimension: int
    unit: str
    scale: float
    best: float
    found_by: str
