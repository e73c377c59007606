"""The calibration as a problem for pymoo: minimise the distances between measured and predicted points."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, final

import numpy as np
from pymoo.core.problem import Problem

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.estimation.multistart import check_bounds
from robolaser.model.blocks.start import conditionally_linear, solve_conditional
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage
from robolaser.parameters import Parameters, Values

AT_ONCE = 400_000  # candidates times rows: some tens of megabytes
BREAKS_SCALE = (Stage.POINTS, Stage.MOUNT)  # with effects here points do not grow with the baseline alone


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

    def __init__(self, dataset: Dataset | str | Path, effects: Sequence[CandidateEffect] = ()) -> None:
        """Take the parameters of the sensor of a data set, or of its folder, and of added effects."""
        self.model = Model(dataset if isinstance(dataset, Dataset) else load(dataset), tuple(effects))
        check_bounds(self.model, "A pymoo algorithm")
        parameters = self.model.parameters
        self.names = parameters.names
        super().__init__(n_var=len(parameters), n_obj=1, xl=parameters.lower, xu=parameters.upper, vtype=float)

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self.model.cost(x)[:, None]


@final
class ReducedCalibration(Problem):
    """Minimise J in the parameters without closed form; the others are optimal within their bounds.

    Of a stripe scanner's fourteen, camera and tilt of the laser plane remain, six numbers with the focal length fixed.
    Of a tracker and of sockets none remain. Parameters of effects are added. `F` is J [m²] of the completed candidate,
    infinite at the model's poles.

    Examples:
        >>> from robolaser.model.forward_model import Model
        >>> from robolaser.problems import ReducedCalibration
        >>> ReducedCalibration(Model(dataset)).n_var < len(Model(dataset).parameters)
        True
    """

    def __init__(self, model: Model) -> None:
        """Take the parameters of a model that do not follow from the others."""
        blocks = model.blocks
        self.model = model
        found = (*conditionally_linear(blocks), *blocks.derived)
        self.parameters = free = model.parameters.without((*found, *blocks.held))
        self.names = free.names
        super().__init__(n_var=len(free), n_obj=1, xl=free.lower, xu=free.upper, vtype=float)

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self.model.cost(self.completed(x))[:, None]

    def completed(self, x: Array) -> Array:
        """Candidates of this problem (c, n_var) as candidates of the whole model (c, d), within its bounds.

        Parameters fixed by the gauge are at their nominal values.
        """
        parts = max(1, -(-len(x) * len(self.model.dataset.points) // AT_ONCE))
        return np.concatenate([self._completed(part) for part in np.array_split(x, parts)])

    def _completed(self, x: Array) -> Array:
        model, whole = self.model, self.model.parameters
        values: Values = dict(zip(whole.names, np.tile(whole.nominal, (len(x), 1)).T, strict=True))
        values = {**values, **_with_baseline(whole, len(x)), **self.parameters.values(x)}
        bounds = {item.name: item for item in whole.items}
        for _ in range(2 if any(effect.effect.stage in BREAKS_SCALE for effect in model.effects) else 1):
            perturb = model.perturb(values)
            flange = model.flange(values, perturb)
            values = {**values, **solve_conditional(model.blocks, values, flange, perturb, bounds)}
        found = np.stack([values[name] for name in whole.names], axis=-1)
        return np.asarray(np.clip(found, whole.lower, whole.upper))


def _with_baseline(whole: Parameters, count: int) -> Values:
    """A nonzero baseline, if there is one, at which points are taken."""
    for item in whole.items:
        if item.name == "b" and item.nominal == 0.0:
            return {"b": np.full(count, max(item.lower, item.upper, key=abs) or 1.0)}
    return {}
