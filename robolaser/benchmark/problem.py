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
    """A cost to be minimised within bounds."""

    name: str  # the user's name for it, and that of all results
    title: str  # a description for a person
    family: str  # `CALIBRATION`, `TEST_FUNCTION` or `OWN`
    variables: tuple[str, ...]  # their names, d of them
    lower: Array  # lower bounds, (d,)
    upper: Array  # upper bounds, (d,)
    cost: Callable[[Array], Array]  # (c, d) -> (c,), of several objectives (c, m); not finite at poles
    unit: str  # of the cost
    scale: float  # a difference in cost that can be neglected where the lowest cost is zero, in `unit`
    residuals: Callable[[Array], Array] | None = None  # (c, d) -> (c, r), whose squares add up to the cost
    model: "Model | None" = None  # the forward model of a calibration
    lowest: float | None = None  # the lowest cost, where theory knows it
    constraints: int = 0  # their number; with any, costs from `INFEASIBLE` on are those of infeasible candidates
    front: "Front | None" = None  # an empty one, if the problem has several objectives
    starts: Array = field(default_factory=lambda: np.empty((0, 0)))  # what every solver begins with, (k, d)

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
    """A problem, and the lowest cost that was ever found."""

    name: str  # name of the problem
    title: str  # a description for a person
    family: str  # see `BenchmarkProblem`
    dimension: int  # number of variables
    unit: str  # of the cost
    scale: float  # unit of the targets' tolerances: the lowest cost itself, unless it is close to zero
    best: float  # the lowest cost known
    found_by: str  # a solver's name, "theory", or "robolaser's own search"
