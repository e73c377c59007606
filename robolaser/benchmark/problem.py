"""A pymoo problem of a comparison, and its known properties."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, final

import numpy as np

from robolaser.arrays import Array

if TYPE_CHECKING:
    from robolaser.model.forward_model import Model

INFEASIBLE = 1e30  # times (1 + violation): cost of infeasible candidates, for algorithms without constraints
EQUAL = 1e-4  # an equality constraint is kept within this, as in pymoo
Family = Literal["calibration", "test function", "own problem", "several objectives"]  # are ranked together


@final
@dataclass(frozen=True)
class ProblemSummary:
    """A problem, and its best known cost."""

    name: str
    title: str  # a description
    family: Family
    dimension: int
    objectives: int
    unit: str = ""  # of the cost
    budget: int = 0  # evaluations of a run
    noisy: bool = False  # runs are ranked by their final candidates, re-evaluated
    floor: float | None = None  # negligible cost, where it has a natural zero; targets are relative then
    lowest: float | None = None  # the lowest cost, where it is known before any run
    front: Any = None  # the theoretical best front, if known, rows of objectives
    found_by: str = ""  # a solver's name, "theory", "robolaser's own search" or, of fronts, "all runs together"
    best: float = np.inf  # the lowest cost known; of several objectives IGD+ of the best front, 0
    fingerprint: str = ""

    @property
    def scale(self) -> float:
        """Unit of the targets' tolerances: the lowest cost where it has a natural zero, else 1."""
        return 1.0 if self.floor is None else max(abs(self.best), self.floor)

    def target(self, tolerance: float) -> float:
        """The target cost."""
        return self.best + tolerance * self.scale


@final
@dataclass(frozen=True, eq=False)
class BenchmarkProblem:
    """Objectives to be minimised within bounds, perhaps under constraints."""

    summary: ProblemSummary
    question: Any  # the pymoo problem
    residuals: Callable[[Array], Array] | None = None  # (c, d) -> (c, r), whose squares add up to the cost
    model: "Model | None" = None  # the forward model of a calibration

    @property
    def name(self) -> str:
        """The user's name for it, and that of all results."""
        return self.summary.name

    @property
    def dimension(self) -> int:
        """Number of variables."""
        return int(self.question.n_var)

    @property
    def n_obj(self) -> int:
        """Number of objectives."""
        return int(self.question.n_obj)

    @property
    def mixed(self) -> bool:
        """Whether candidates are dictionaries of variables of several types."""
        return getattr(self.question, "vars", None) is not None

    @property
    def discrete(self) -> bool:
        """Whether all variables are whole numbers or bits."""
        return self.question.vtype in (int, bool)

    @property
    def variables(self) -> tuple[str, ...]:
        """Their names, d of them."""
        if self.mixed:
            return tuple(self.question.vars)
        return tuple(getattr(self.question, "names", None) or (f"x{i}" for i in range(self.dimension)))

    @property
    def lower(self) -> Array:
        """Lower bounds, (d,)."""
        return np.asarray(self.question.xl, np.float64)

    @property
    def upper(self) -> Array:
        """Upper bounds, (d,)."""
        return np.asarray(self.question.xu, np.float64)

    def sample_uniform(self, rng: np.random.Generator, candidates: int = 1) -> Any:
        """Candidates, uniform within the bounds, (candidates, d), or (candidates,) of dictionaries."""
        if self.mixed:
            values = [var.sample(candidates, random_state=rng) for var in self.question.vars.values()]
            return np.array([dict(zip(self.question.vars, row, strict=True)) for row in zip(*values, strict=True)])
        if self.discrete:
            low, high = self.lower.astype(np.int64), self.upper.astype(np.int64)
            return rng.integers(low, high + 1, (candidates, self.dimension)).astype(np.float64)
        return rng.uniform(self.lower, self.upper, (candidates, self.dimension))

    def values(self, x: Any) -> Mapping[str, Array]:
        """Objectives F (c, m) of candidates, and of the constraints G (c, g), at most 0, and H (c, h), which is 0."""
        widths = {"F": self.n_obj, "G": self.question.n_ieq_constr, "H": self.question.n_eq_constr}
        if not len(x):  # a user's problem need not evaluate none
            return {name: np.empty((0, width)) for name, width in widths.items()}
        x = x.astype(bool) if self.question.vtype is bool else x
        found = self.question.evaluate(x, return_values_of=[*widths], return_as_dictionary=True)
        values = {name: np.array(found[name], np.float64).reshape(len(x), width) for name, width in widths.items()}
        return {**values, "F": np.where(np.isnan(values["F"]), np.inf, values["F"])}

    def violation(self, values: Mapping[str, Array]) -> Array:
        """Sum of the violations of constraints, (c,)."""
        H = np.abs(values["H"])
        total: Array = np.maximum(values["G"], 0.0).sum(axis=1) + np.where(H > EQUAL, H, 0.0).sum(axis=1)
        return np.where(np.isnan(total), np.inf, total)


@final
@dataclass(frozen=True, eq=False)
class ProblemSpec:
    """Builds a problem in a process, a new one for each run, so that runs do not share state."""

    name: str  # the problem's
    makers: tuple[Callable[[], BenchmarkProblem], ...]  # one for each instance; runs with seeds 1, 2, ... take turns

    def made_for(self, seed: int) -> BenchmarkProblem:
        """The problem of a run with this seed."""
        return self.makers[(seed - 1) % len(self.makers)]()
