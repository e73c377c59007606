"""Calibrations with known optima, as problems for pymoo, for ioh, and for loops written for COCO."""

import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, final

import msgspec
import numpy as np
from pymoo.core.problem import Problem

from robolaser.arrays import Array
from robolaser.data.loading import load
from robolaser.errors import UsageError, near
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.plugins import extra
from robolaser.problems.calibration import ReducedCalibration

FOLDER = Path(__file__).parent
DATA, TABLE = FOLDER / "data", FOLDER / "instances.toml"
TARGET = 1.01  # J that counts as the optimum, in units of the lowest known


@final
@dataclass(frozen=True)
class Instance:
    """A data set, seen through a model, and its lowest known J."""

    id: str
    title: str
    data: str  # the data set's folder
    effects: tuple[str, ...] = ()  # effects in the model besides the sensor, as `--with` takes them
    held: tuple[str, ...] = ()  # parameters that stay at their nominal values
    reduced: bool = False  # without the parameters that follow from the others in closed form
    best: float = float("inf")  # lowest known J; m², of cameras px²
    best_x: tuple[float, ...] = ()  # where that is
    starts: int = 0  # descents that were made, from starts that are uniform within the bounds
    reached: int = 0  # of them that ended within one per cent of the lowest J


@cache
def instances() -> dict[str, Instance]:
    """All of them, by id, in their order."""
    found = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    return {name: msgspec.convert({"id": name, **entry}, Instance) for name, entry in found.items()}


def _instance_named(name: str) -> Instance:
    if name not in instances():
        raise UsageError(f"The suite has no instance '{name}'.{near(name, list(instances()))}")
    return instances()[name]


@final
class SuiteProblem(Problem):
    """Minimise J of a calibration whose lowest J is known, within bounds. J is infinite at the model's poles.

    To pymoo it is a problem like any other. For loops that are written for COCO it has `cocoex`'s names.

    Attributes:
        id: Its name in the suite.
        title: What was measured.
        names: Of the variables, in SI units and pixels.
        model: The calibration's model.
        instance: Its entry in the suite: `best`, the lowest known J, `best_x`, and how that was found.
        dimension: Number of variables.
        evaluations: Candidates evaluated so far.
        best_observed_fvalue1: The lowest J so far.
        final_target_fvalue1: One per cent above the lowest known J.

    Examples:
        >>> from robolaser.problems import suite
        >>> problem = suite()["lee2004"]
        >>> problem(problem.best_x) == problem.lowest, problem.evaluations, problem.final_target_hit
        (True, 1, True)
    """

    number_of_objectives, number_of_constraints = 1, 0

    def __init__(self, instance: Instance) -> None:
        """Build the problem of an instance; `suite()` does."""
        dataset = load(DATA / instance.data)
        self.model = Model(dataset, candidate_effects(instance.effects, dataset))
        self._reduction = ReducedCalibration(self.model) if instance.reduced else None
        free = self._reduction.parameters if self._reduction else self.model.parameters.without(instance.held)
        self._columns = self.model.parameters.columns(free.names)
        self.instance, self.id, self.title, self.names = instance, instance.id, instance.title, free.names
        self.lowest, self.best_x = instance.best, np.array(instance.best_x)
        self.final_target_fvalue1 = TARGET * instance.best
        self.evaluations, self.best_observed_fvalue1 = 0, np.inf
        super().__init__(n_var=len(free), n_obj=1, xl=free.lower, xu=free.upper, vtype=float)
        self.dimension, self.lower_bounds, self.upper_bounds = len(free), free.lower, free.upper
        self.initial_solution = (free.lower + free.upper) / 2

    def completed(self, x: Array) -> Array:
        """Candidates (c, dimension) as those of the whole model (c, d)."""
        if self._reduction is not None:
            return self._reduction.completed(x)
        whole = np.tile(self.model.parameters.nominal, (len(x), 1))
        whole[:, self._columns] = x
        return whole

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        J = self.model.cost(self.completed(x))
        self.evaluations += len(x)
        self.best_observed_fvalue1 = min(self.best_observed_fvalue1, float(J.min(initial=np.inf)))
        out["F"] = J[:, None]

    def __call__(self, x: Sequence[float] | Array) -> float:
        """J of one candidate, (dimension,)."""
        return float(self.evaluate(np.asarray(x, np.float64)[None])[0, 0])

    @property
    def final_target_hit(self) -> bool:
        """Whether some candidate came within one per cent of the lowest known J."""
        return bool(self.best_observed_fvalue1 <= self.final_target_fvalue1)

    def as_ioh(self) -> Any:
        """The same as a problem of ioh, for its loggers: variables from 0 to 1, bound to bound.

        Raises:
            DependencyMissing: `ioh` is not installed.
        """
        ioh = extra("ioh", "`as_ioh` needs `ioh`: pip install 'robolaser[bbob]'.")
        width = self.upper_bounds - self.lower_bounds
        best: list[float] = ((self.best_x - self.lower_bounds) / width).tolist()
        return ioh.wrap_problem(
            lambda u: self(self.lower_bounds + np.asarray(u) * width),
            name=f"robolaser-{self.id}",
            dimension=self.dimension,
            lb=0.0,
            ub=1.0,
            calculate_objective=lambda instance, dimension: (best, self.lowest),
        )


@final
class Suite:
    """Problems in a fixed order; each access returns a new one, with no evaluations yet.

    Examples:
        >>> from robolaser.problems import suite
        >>> [(problem.id, problem.dimension) for problem in suite(["lee2004", "lee2004-reduced"])]
        [('lee2004', 14), ('lee2004-reduced', 6)]
    """

    def __init__(self, ids: Sequence[str]) -> None:
        self.ids = tuple(ids)

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, which: int | str) -> SuiteProblem:
        """The problem of this number or id.

        Raises:
            UsageError: There is none of that id.
            IndexError: There is none of that number.
        """
        return SuiteProblem(_instance_named(which if isinstance(which, str) else self.ids[which]))

    def __iter__(self) -> Iterator[SuiteProblem]:
        return (self[name] for name in self.ids)


def suite(ids: Sequence[str] | None = None) -> Suite:
    """Calibrations of scanners, cameras and arms, measured and simulated, with the lowest known J of each.

    Args:
        ids: Those wanted, in this order; all when absent.

    Raises:
        UsageError: There is no instance of that id.

    Examples:
        >>> from robolaser.problems import suite
        >>> problem = suite()["ur5-tracker"]
        >>> minimize(problem, GA(pop_size=20), ("n_eval", 200), seed=1).F[0] > problem.lowest
        np.True_
    """
    return Suite([_instance_named(name).id for name in (instances() if ids is None else ids)])
