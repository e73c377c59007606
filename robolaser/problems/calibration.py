"""The calibration as a question for pymoo: which parameters bring measured and predicted points together?"""

from collections.abc import Sequence
from typing import Any, final

from pymoo.core.problem import Problem

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.estimation.multistart import check_bounds
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model


@final
class ScannerCalibration(Problem):
    """Minimise J, the sum of squared distances between known and predicted points. Lee et al. 2004, eqs. 14-18.

    `x` is in SI units within `xl` .. `xu`, the bounds of the data set, in the order of `names`; `F` is J [m²],
    infinite at the model's poles. Vectorised: a population is one batch.

    Examples:
        >>> from robolaser.problems import ScannerCalibration
        >>> problem = ScannerCalibration(dataset)
        >>> problem.names[:3]
        ('f', 's_u', 's_v')
        >>> problem.evaluate(np.array([problem.xl, problem.xu])).shape
        (2, 1)
    """

    def __init__(self, dataset: Dataset, effects: Sequence[CandidateEffect] = ()) -> None:
        """Ask for the parameters of a data set's sensor, and of the effects added to the model."""
        self.model = Model(dataset, tuple(effects))
        check_bounds(self.model, "A pymoo algorithm")
        parameters = self.model.parameters
        self.names = parameters.names
        super().__init__(n_var=len(parameters), n_obj=1, xl=parameters.lower, xu=parameters.upper, vtype=float)

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self.model.cost(x)[:, None]
