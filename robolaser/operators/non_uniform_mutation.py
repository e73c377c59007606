"""Non-uniform mutation: steps that shrink as the run goes on."""

import math
from collections.abc import Callable, Iterator
from typing import Any, final

import numpy as np
from pymoo.core.mutation import Mutation
from pymoo.core.termination import Termination
from pymoo.core.variable import Real, get
from pymoo.termination.delta import DeltaToleranceTermination
from pymoo.termination.fmin import MinimumFunctionValueTermination
from pymoo.termination.indicator import IndicatorTermination

from robolaser.arrays import Array, Bools
from robolaser.errors import AlgorithmError
from robolaser.operators.bounds import check_share, finite_bounds

HORIZON = 10_000  # default length of a run in generations: Lee et al.'s stop
_CONVERGENCE = (DeltaToleranceTermination, IndicatorTermination, MinimumFunctionValueTermination)
"""Their share measures how little still changes, not time: it starts near 1 where costs are small."""


def step_size(r: Array, progress: float, b: float) -> Array:
    """Step as a share of the distance to the bound, (...) -> (...), between 0 and 1. Lee et al. 2004, eq. 23.

    By uniform draws from 0 to 1, the progress k/T, and the non-uniformity b: how soon the steps shrink.
    """
    return r * float((1.0 - progress) ** b)


def non_uniform(genes: Array, lower: Array, upper: Array, upward: Bools, share: Array) -> Array:
    """Move genes by a share of the distance to the bound ahead, all (...) -> (...). Eq. 22.

    As printed, (22) uses the whole range as distance; this is Michalewicz's form, which stays within the bounds.
    """
    ahead = np.where(upward, upper, lower) - genes
    return np.minimum(np.maximum(genes + ahead * share, lower), upper)


@final
class NonUniformMutation(Mutation):
    """Non-uniform mutation for pymoo.

    Draws from `random_state`, for (n, d) individuals: the genes to move, random((n, d)) < prob_var; then for
    the h that move, row by row, the directions, random(h) < 0.5 is up; then r, random(h). pymoo's
    `Mutation.do` draws random(n) afterwards and keeps the mutants where it is at most `prob`.

    Args:
        prob_var: Probability that a gene is moved.
        b: Non-uniformity: how soon the steps shrink.
        progress: k/T, or a function without arguments that returns it, for algorithms that do not pass themselves to
            their operators. By default it is the algorithm's own, see `_run_progress`.
        prob: Probability that an individual takes part.

    Raises:
        AlgorithmError: A setting is invalid; when called, if a variable has no finite bounds, or if there is
            neither an algorithm nor `progress`.

    Examples:
        >>> from robolaser.operators import NonUniformMutation
        >>> result = minimize(sphere, GA(mutation=NonUniformMutation(prob_var=0.1, b=5)), ("n_gen", 20), seed=1)
        >>> bool(result.F[0] < 0.1)
        True
    """

    def __init__(
        self,
        prob_var: float = 0.1,
        b: float = 5.0,
        *,
        progress: float | Callable[[], float] | None = None,
        prob: float = 1.0,
        **kwargs: Any,
    ) -> None:
        super().__init__(prob=prob, prob_var=prob_var, **kwargs)
        for setting, value in (("prob", prob), ("prob_var", prob_var), ("progress", progress)):
            check_share(self.name, setting, value)
        if not b >= 0:
            raise AlgorithmError(f"{self.name}: b is {b!r}, expected a number of at least 0.")
        self.b = Real(b, bounds=(1.0, 10.0), strict=(0.0, None))
        self.progress = progress

    def _do(self, problem: Any, X: Array, *args: Any, random_state: Any, algorithm: Any = None, **kwargs: Any) -> Array:
        lower, upper = finite_bounds(problem, self.name)
        mutated = random_state.random(X.shape) < self.get_prob_var(problem, size=len(X))[:, None]
        gene = np.nonzero(mutated)[1]
        upward = random_state.random(len(gene)) < 0.5
        share = step_size(random_state.random(len(gene)), self.progress_of(algorithm), get(self.b))

        mutants = np.clip(X.astype(np.float64), lower, upper)
        mutants[mutated] = non_uniform(mutants[mutated], lower[gene], upper[gene], upward, share)
        return mutants

    def progress_of(self, algorithm: Any) -> float:
        """k/T of a run, from 0 to 1.

        Raises:
            AlgorithmError: There is neither an algorithm nor `progress`.
        """
        if self.progress is not None:
            return _share(self.progress() if callable(self.progress) else self.progress)
        if algorithm is None:
            raise AlgorithmError(
                f"{self.name} does not know how far the run has come: its algorithm does not pass itself on to its"
                f" operators (MOEAD and differential evolution do not). Pass {self.name}(progress=...), a share of the"
                " run from 0 to 1 or a function without arguments that returns it."
            )
        return _run_progress(algorithm)


def _run_progress(algorithm: Any) -> float:
    """Completed share k/T of the run, from 0 to 1, for the present generation.

    k is `algorithm.n_iter` − 1: 0 for the initial population, 1 for its first children. The earliest end counts:
    k/T is the largest of k over `n_max_gen` and of the used shares of the budgets of evaluations and time, anywhere in
    the algorithm's termination. Without any of these, T is 10 000 generations, or k/T the progress of a termination of
    unknown kind if that is more.
    """
    k = (algorithm.n_iter or 1) - 1
    leaves = list(_leaves(algorithm.termination))
    ends = [k / max(last, 1) for last in _limits(leaves, "n_max_gen")]
    ends += [leaf.perc for leaf in leaves if _limits([leaf], "n_max_evals") or _limits([leaf], "max_time")]
    if ends:
        return _share(max(ends))
    shares = [getattr(leaf, "perc", 0.0) for leaf in leaves if not isinstance(leaf, _CONVERGENCE)]
    return _share(max([k / HORIZON, *shares]))


def _leaves(termination: Any) -> Iterator[Any]:
    """Walk through the terminations that contain no others, each once."""
    parts = [
        part
        for value in vars(termination).values()
        for part in (value if isinstance(value, (list, tuple)) else (value,))
        if isinstance(part, Termination)
    ]
    if not parts:
        yield termination
    for part in parts:
        yield from _leaves(part)


def _limits(leaves: list[Any], name: str) -> list[float]:
    limits = (getattr(leaf, name, None) for leaf in leaves)
    return [float(limit) for limit in limits if limit is not None and math.isfinite(limit)]


def _share(value: float) -> float:
    return float(min(max(value, 0.0), 1.0))
