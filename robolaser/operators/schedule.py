"""Progress k/T of a run, from the algorithm's termination."""

import math
from collections.abc import Iterator
from typing import Any

from pymoo.core.termination import Termination
from pymoo.termination.delta import DeltaToleranceTermination
from pymoo.termination.fmin import MinimumFunctionValueTermination
from pymoo.termination.indicator import IndicatorTermination

HORIZON = 10_000  # generations that a run is taken to last where nothing says so: Lee et al.'s stop

_CONVERGENCE = (DeltaToleranceTermination, IndicatorTermination, MinimumFunctionValueTermination)
"""Their share says how little still changes, which is no clock: it starts near 1 where costs are small."""


def progress(algorithm: Any, last_generation: float | None = None) -> float:
    """Share k/T of the run that lies behind, from 0 to 1, for the generation that is being made.

    k is `algorithm.n_iter` − 1: 0 for the initial population, 1 for its first children. T is `last_generation`.
    Without it, the end that comes first counts: k/T is the largest of k over `n_max_gen` and of the shares used up
    of the budgets of evaluations and time, wherever they stand in the algorithm's termination. Without any of
    these, T is 10 000 generations, or k/T what a termination of unknown kind says of itself if that is more.
    """
    k = (algorithm.n_iter or 1) - 1
    if last_generation is not None:
        return _share(k / max(last_generation, 1))
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
