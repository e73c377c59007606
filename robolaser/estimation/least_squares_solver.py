"""What takes a calibration from a good start to its optimum: our solver, or one that an installed package announces."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cache
from typing import ClassVar, Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import EstimationError, UsageError, near
from robolaser.estimation.least_squares import LeastSquares
from robolaser.estimation.solver import solve
from robolaser.plugins import announced

GROUP: Final = "robolaser.solvers"  # entry points under which installed packages announce solvers


class LeastSquaresSolver(ABC):
    """A method that minimises sums of squares within bounds."""

    name: ClassVar[str]  # by which it is chosen
    title: ClassVar[str]  # a description for a person

    @abstractmethod
    def minimize(self, problem: LeastSquares, start: Array, *, tol: float) -> tuple[Array, int]:
        """Descend to the optimum of the valley in which the start lies.

        Args:
            problem: What to minimise; `FlatProblem` shows it as one vector of residuals.
            start: (d,), within the bounds.
            tol: Share of the cost by which the optimum may be missed.

        Returns:
            The optimum (d,), within the bounds, and the number of residual vectors that were evaluated.
        """


@final
class LevenbergMarquardt(LeastSquaresSolver):
    """Ours, `solve`, from one start."""

    name = "levenberg-marquardt"
    title = "robolaser's bounded Levenberg-Marquardt with geodesic acceleration"

    def minimize(self, problem: LeastSquares, start: Array, *, tol: float) -> tuple[Array, int]:
        """See `LeastSquaresSolver`."""
        end = solve(problem, start[None], tol=tol)
        return end.x[0], end.evaluations


DEFAULT: Final = LevenbergMarquardt()


@cache
def solvers() -> Mapping[str, type[LeastSquaresSolver]]:
    """Our solver and those that installed packages announce, by name.

    Raises:
        PluginError: What a package announces cannot be used.
    """
    ours: dict[str, type[LeastSquaresSolver]] = {DEFAULT.name: LevenbergMarquardt}
    return ours | announced(GROUP, LeastSquaresSolver, taken=ours, required=["title"])


def solver_named(name: str) -> LeastSquaresSolver:
    """The solver of that name.

    Raises:
        UsageError: There is none.
        PluginError: What an installed package announces cannot be used.
    """
    if name == DEFAULT.name:
        return DEFAULT
    if name not in solvers():
        raise UsageError(f"No solver '{name}'.{near(name, solvers())}")
    return solvers()[name]()


def minimized(solver: LeastSquaresSolver, problem: LeastSquares, start: Array, *, tol: float) -> tuple[Array, int]:
    """Let a solver descend, and see that where it ended is an answer.

    Args:
        solver: Any.
        problem: What to minimise.
        start: (d,); moved to the nearest point within the bounds.
        tol: See `LeastSquaresSolver.minimize`.

    Returns:
        The optimum (d,), and the number of residual vectors that were evaluated.

    Raises:
        EstimationError: It ended outside the bounds, at no finite place, or with another number of parameters.
    """
    x, evaluations = solver.minimize(problem, np.clip(start, problem.lower, problem.upper), tol=tol)
    x = np.asarray(x, np.float64)
    if x.shape != start.shape:
        raise EstimationError(
            f"The solver {solver.name} gave parameters of shape {x.shape}, expected {start.shape}: report it to whoever"
            " wrote the solver, or use another."
        )
    if outside := int(np.count_nonzero(~((x >= problem.lower) & (x <= problem.upper)))):
        raise EstimationError(
            f"The solver {solver.name} ended with {outside} of {len(x)} parameters outside their bounds or not finite:"
            " report it to whoever wrote the solver, or use another."
        )
    return x, evaluations
