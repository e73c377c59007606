"""Others' ways to the optimum, each started anew whenever it stops, until it has found it or its time is up.

Each gets the compiled cost, populations in one batch where it takes them, the bounds of Table 2 and its own defaults.
"""

import math
import sys
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, final

import cma
import numpy as np
from pymoo.algorithms.soo.nonconvex.cmaes import CMAES
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.algorithms.soo.nonconvex.pso import PSO
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from scipy.optimize import differential_evolution, least_squares

from robolaser.arrays import Array
from robolaser.model.forward_model import Model

sys.path.append(str(Path(__file__).parents[1] / "kernel"))
from peer import Plain

TIGHT = 1e-12  # least_squares stops at 1e-8 by default, in a flat valley before the optimum
SIGMA = 0.3  # of the unit box: what the authors of CMA-ES advise


class Over(Exception):
    """The optimum was found, or the time is up."""


@final
class Race:
    """One run of one way: counts its time and keeps the lowest cost that it has asked for.

    Args:
        model: Of the experiment.
        limit: J at or below which the optimum is found [m²].
        cap: Processor seconds that the run may take.
        seed: Of the run.
    """

    def __init__(self, model: Model, limit: float, cap: float, seed: int) -> None:
        self.model, self.limit, self.cap = model, limit, cap
        self.rng = np.random.default_rng(seed)
        self.lower, self.upper = model.parameters.lower, model.parameters.upper
        self.best = math.inf
        self.began = time.process_time()

    def seconds(self) -> float:
        """Processor time so far."""
        return time.process_time() - self.began

    def seed(self) -> int:
        """Of the next start."""
        return int(self.rng.integers(1, 2**31))

    def anywhere(self) -> Array:
        """A start, uniform in the bounds, (d,)."""
        x: Array = self.rng.uniform(self.lower, self.upper)
        return x

    def saw(self, J: float) -> None:
        """Take note of a cost.

        Raises:
            Over: No need, or no time, to look further.
        """
        self.best = min(self.best, J)  # a pole's, which is not a number, is not taken
        if self.best <= self.limit or self.seconds() > self.cap:
            raise Over

    def cost(self, x: Array) -> Array:
        """J of candidates (c, d) -> (c,) [m²]."""
        J = self.model.cost(x)
        self.saw(float(np.min(J)))
        return J

    def cost_in_unit_box(self, y: Array) -> Array:
        """The same, the bounds scaled to 0 and 1."""
        return self.cost(self.lower + y * (self.upper - self.lower))


def local(race: Race, residuals: Callable[[Array], Array]) -> None:
    """SciPy's least_squares (trf) from random starts; x (1, d) -> residuals (1, ...)."""

    def noted(x: Array) -> Array:
        e = residuals(x[None]).reshape(-1)
        race.saw(float(e @ e))
        return e

    while True:
        try:
            least_squares(
                noted,
                race.anywhere(),
                bounds=(race.lower, race.upper),
                x_scale=race.upper - race.lower,
                ftol=TIGHT,
                xtol=TIGHT,
                gtol=TIGHT,
            )
        except ValueError:  # the start, or a step of its differences, lies at a pole
            race.saw(math.inf)


def local_compiled(race: Race) -> None:
    local(race, race.model.residuals)


def local_numpy(race: Race) -> None:
    local(race, Plain.of(race.model.dataset).residuals)


def scipy_evolution(race: Race) -> None:
    """SciPy's differential_evolution."""
    bounds = list(zip(race.lower, race.upper, strict=True))
    while True:
        differential_evolution(
            lambda x: race.cost(np.atleast_2d(x.T)).squeeze(),
            bounds,
            vectorized=True,
            updating="deferred",
            rng=race.seed(),
        )


def pymoo(algorithm: Callable[[], Any]) -> Callable[[Race], None]:
    """An algorithm of pymoo."""

    def run(race: Race) -> None:
        while True:
            minimize(_Question(race), algorithm(), seed=race.seed())

    return run


@final
class _Question(Problem):
    def __init__(self, race: Race) -> None:
        self.race = race
        super().__init__(n_var=len(race.lower), n_obj=1, xl=race.lower, xu=race.upper, vtype=float)

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self.race.cost(x)[:, None]


def pycma(race: Race) -> None:
    """CMA-ES with BIPOP restarts, by its authors, in the unit box."""
    d = len(race.lower)
    while True:
        cma.fmin2(
            None,
            lambda: race.rng.uniform(size=d),
            SIGMA,
            {"bounds": [0, 1], "seed": race.seed(), "verbose": -9},
            restarts=9,
            bipop=True,
            parallel_objective=lambda y: race.cost_in_unit_box(np.array(y)).tolist(),
        )


PEERS: dict[str, Callable[[Race], None]] = {
    "least_squares": local_compiled,
    "least_squares, NumPy": local_numpy,
    "differential_evolution": scipy_evolution,
    "pymoo GA": pymoo(GA),
    "pymoo DE": pymoo(DE),
    "pymoo PSO": pymoo(PSO),
    "pymoo CMAES": pymoo(CMAES),
    "pycma BIPOP": pycma,
}


def race(name: str, model: Model, limit: float, cap: float, seed: int) -> tuple[float, float]:
    """Let one run.

    Returns:
        Processor seconds it took, and the lowest J it saw [m²]: above the limit where its time was up.
    """
    run = Race(model, limit, cap, seed)
    with warnings.catch_warnings(), np.errstate(all="ignore"), suppress(Over):
        warnings.simplefilter("ignore")
        PEERS[name](run)
    return run.seconds(), run.best
