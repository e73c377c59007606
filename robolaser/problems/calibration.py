"""The calibration as a question for pymoo: which parameters bring measured and predicted points together?"""

from collections.abc import Sequence
from typing import Any, final

import numpy as np
from pymoo.core.problem import Problem

from robolaser.arrays import Array
from robolaser.dataset import Dataset
from robolaser.effects.effect import Suspect
from robolaser.scanner import Model, sum_of_squares


@final
class ScannerCalibration(Problem):
    """Minimise J, the sum of squared distances between known and predicted points. Lee et al. 2004, eqs. 14-18.

    `x` is in SI units within `xl` .. `xu`, the bounds of the data set, in the order of `names`; `F` is J [m²],
    infinite at the model's poles. Vectorised: a population is one batch.
    """

    def __init__(self, dataset: Dataset, effects: Sequence[Suspect] = ()) -> None:
        """Ask for the parameters of a data set's sensor, and of the effects added to the model."""
        self.model = Model(dataset, tuple(effects))
        parameters = self.model.parameters
        self.names = parameters.names
        super().__init__(n_var=len(parameters), n_obj=1, xl=parameters.lower, xu=parameters.upper, vtype=float)

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self.model.cost(x)[:, None]


@final
class ReducedCalibration(Problem):
    """The same question with the parameters left out that follow from the others in closed form.

    For each candidate an unplaced target stands where it fits best (Umeyama 1991), so the search is in the scanner's
    own parameters and those of the effects.
    """

    def __init__(self, model: Model) -> None:
        """Ask for the parameters of a model that do not follow from the others."""
        self.model = model
        parameters = model.parameters.without(model.sensor.following)
        self._free = parameters
        self.names = parameters.names
        super().__init__(n_var=len(parameters), n_obj=1, xl=parameters.lower, xu=parameters.upper, vtype=float)

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = sum_of_squares(self.model.residuals(self.completed(x)))[:, None]

    def completed(self, x: Array) -> Array:
        """Candidates of this problem (c, n_var) as candidates of the whole model (c, d), within its bounds."""
        whole = self.model.parameters
        values = self.model.completed(self._free.values(x))
        stacked = np.stack([np.broadcast_to(values[name], len(x)) for name in whole.names], axis=-1)
        return np.clip(stacked, whole.lower, whole.upper)
