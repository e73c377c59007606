"""The calibration with the parameters left out that follow from the others."""

from typing import Any, final

from pymoo.core.problem import Problem

from robolaser.arrays import Array
from robolaser.estimation.reduction import Reduction
from robolaser.model.forward_model import Model


@final
class ReducedCalibration(Problem):
    """Minimise J in the parameters that do not follow from the others; the others are the best within their bounds.

    `F` is J [m²] of the completed candidate, infinite at the model's poles.
    """

    def __init__(self, model: Model) -> None:
        """Ask for the parameters of a model that do not follow from the others."""
        self.model = model
        self._reduction = Reduction(model)
        free = self._reduction.parameters
        self.names = free.names
        super().__init__(n_var=len(free), n_obj=1, xl=free.lower, xu=free.upper, vtype=float)

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self.model.cost(self.completed(x))[:, None]

    def completed(self, x: Array) -> Array:
        """Candidates of this problem (c, n_var) as candidates of the whole model (c, d), within its bounds."""
        return self._reduction.completed(x)
