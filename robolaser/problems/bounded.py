"""Any cost within bounds as a question for pymoo."""

from collections.abc import Callable
from typing import Any, final

from pymoo.core.problem import Problem

from robolaser.arrays import Array


@final
class Bounded(Problem):
    """Minimise a cost (c, d) -> (c,), or objectives (c, m), between lower and upper bounds, (d,) each."""

    def __init__(self, cost: Callable[[Array], Array], lower: Array, upper: Array, *, n_obj: int = 1) -> None:
        self._cost = cost
        super().__init__(n_var=len(lower), n_obj=n_obj, xl=lower.copy(), xu=upper.copy(), vtype=float)

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self._cost(x).reshape(len(x), self.n_obj)
