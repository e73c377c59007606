"""Calibrations with known optima, each as a question for pymoo."""

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
from robolaser.problems.calibration import ReducedModel

FOLDER = Path(__file__).parent
DATA, TABLE = FOLDER / "data", FOLDER / "instances.toml"


@final
@dataclass(frozen=True)
class Instance:
    """A data set, seen through a model, and its lowest known J."""

    id: str
    title: str
    data: str  # the data set's folder
    effects: tuple[str, ...] = ()  # that the model has beside the sensor, as `--with` takes them
    held: tuple[str, ...] = ()  # parameters that stay at their nominal values
    reduced: bool = False  # without the parameters that follow from the others in closed form
    best: float = float("inf")  # lowest J that anybody found; m², of cameras px²
    best_x: tuple[float, ...] = ()  # where that is
    starts: int = 0  # descents that were made, from starts that are uniform within the bounds
    reached: int = 0  # of them that ended within one per cent of the lowest J


@cache
def instances() -> dict[str, Instance]:
    """All of them, by id, in their order."""
    found = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    return {name: msgspec.convert({"id": name, **entry}, Instance) for name, entry in found.items()}


@final
class SuiteProblem(Problem):
    """Minimise J of a calibration whose lowest J is known, within bounds. J is infinite at the model's poles.

    Attributes:
        id: Its name in the suite.
        title: What was measured.
        names: Of the variables, in SI units and pixels.
        model: The calibration's model.
        instance: Its entry in the suite, with how its optimum was found.
        lowest: The lowest known J.
        best_x: Where that is.

    Examples:
        >>> from robolaser.problems import suite
        >>> (problem,) = suite(["lee2004"])
        >>> problem.n_var, problem.evaluate(problem.best_x)[0] == problem.lowest
        (14, np.True_)
    """

    def __init__(self, instance: Instance) -> None:
        """Build the problem of an instance; `suite()` does."""
        dataset = load(DATA / instance.data)
        self.model = Model(dataset, candidate_effects(instance.effects, dataset))
        self._reduction = ReducedModel(self.model) if instance.reduced else None
        free = self._reduction.parameters if self._reduction else self.model.parameters.without(instance.held)
        self._columns = self.model.parameters.columns(free.names)
        self.instance, self.id, self.title, self.names = instance, instance.id, instance.title, free.names
        self.lowest, self.best_x = instance.best, np.array(instance.best_x)
        super().__init__(n_var=len(free), n_obj=1, xl=free.lower, xu=free.upper, vtype=float)

    def completed(self, x: Array) -> Array:
        """Candidates (c, n_var) as those of the whole model (c, d)."""
        if self._reduction is not None:
            return self._reduction.completed(x)
        whole = np.tile(self.model.parameters.nominal, (len(x), 1))
        whole[:, self._columns] = x
        return whole

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self.model.cost(self.completed(x))[:, None]


def suite(ids: Sequence[str] | None = None) -> Iterator[SuiteProblem]:
    """Calibrations of scanners, cameras and arms, measured and simulated, with the lowest J that is known of each.

    Args:
        ids: Those wanted, in this order; all when absent.

    Raises:
        UsageError: There is no instance of that id.

    Examples:
        >>> from robolaser.problems import suite
        >>> (problem,) = suite(["ur5-tracker"])
        >>> minimize(problem, GA(pop_size=20), ("n_eval", 200), seed=1).F[0] > problem.lowest
        np.True_
    """
    known = instances()
    for name in known if ids is None else ids:
        if name not in known:
            raise UsageError(f"The suite has no instance '{name}'.{near(name, list(known))}")
        yield SuiteProblem(known[name])
