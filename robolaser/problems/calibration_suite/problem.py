"""An instance of the suite as a question for pymoo, for ioh, and for loops that are written for COCO."""

from collections.abc import Sequence
from typing import Any, final

import numpy as np
from pymoo.core.problem import Problem

from robolaser.arrays import Array
from robolaser.data.loading import load
from robolaser.errors import DependencyMissing
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.problems.calibration_suite.instance import DATA, Instance
from robolaser.problems.reduction import ReducedModel

TARGET = 1.01  # J that counts as the optimum, in units of the lowest known


@final
class SuiteProblem(Problem):
    """Minimise J of a calibration whose lowest J is known, within bounds. J is infinite at the model's poles.

    To pymoo it is a problem like any other. For loops that are written for COCO it has `cocoex`'s names.

    Attributes:
        id: Its name in the suite.
        title: What was measured.
        names: Of the variables, in SI units and pixels.
        model: The calibration's model.
        instance: What the suite says of it: `best`, the lowest known J, `best_x`, and how that was found.
        dimension: Number of variables.
        evaluations: Candidates evaluated so far.
        best_observed_fvalue1: The lowest J so far.
        final_target_fvalue1: One per cent above the lowest J known.

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
        self._reduction = ReducedModel(self.model) if instance.reduced else None
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
        """Whether some candidate came within one per cent of the lowest J known."""
        return bool(self.best_observed_fvalue1 <= self.final_target_fvalue1)

    def as_ioh(self) -> Any:
        """The same as a problem of ioh, whose loggers can be attached to it: variables from 0 to 1, bound to bound.

        Raises:
            DependencyMissing: `ioh` is not installed.
        """
        try:
            import ioh  # noqa: PLC0415 - an extra
        except ImportError:
            raise DependencyMissing("`as_ioh` needs `ioh`: pip install 'robolaser[bbob]'.") from None
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
