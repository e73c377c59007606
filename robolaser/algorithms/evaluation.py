"""Evaluation of candidates by a pymoo problem, without pymoo's overhead where it makes no difference."""

from typing import Any

import numpy as np
from pymoo.core.problem import Problem

from robolaser.arrays import Array

_DETOURS = ("evaluate", "do", "_evaluate_vectorized", "_format_dict")


def evaluated(problem: Any, X: Array, names: list[str], algorithm: Any) -> dict[str, Any]:
    """Evaluate candidates (n, d) as pymoo's evaluator would: (n, ...) each, by pymoo's names.

    Without constraints there may be no G and H, which are empty then.

    Args:
        problem: Any pymoo problem.
        X: Candidates; the problem may write to them.
        names: Values wanted, F among them.
        algorithm: Passed to problems that ask for it.
    """
    if not _is_plain(problem):
        return dict(problem.evaluate(X, return_values_of=names, return_as_dictionary=True, algorithm=algorithm))
    out: dict[str, Any] = dict.fromkeys(names)
    problem._evaluate(X, out, **({"algorithm": algorithm} if problem.requires_kwargs else {}))
    F = out["F"]
    if type(F) is np.ndarray and F.dtype == np.float64 and F.size == len(X) and _has_only_costs(out):
        return {"F": F.reshape(-1, 1).copy()}
    values = problem._format_dict(out, len(X), names)
    return {name: _as_float(np.array(value)) for name, value in values.items()}


def _is_plain(problem: Any) -> bool:
    """Whether a problem is evaluated in one go and has no constraints."""
    kind = type(problem)
    return (
        kind.evaluate is Problem.evaluate
        and kind.do is Problem.do
        and kind._evaluate_vectorized is Problem._evaluate_vectorized
        and kind._format_dict is Problem._format_dict
        and vars(problem).keys().isdisjoint(_DETOURS)
        and not problem.elementwise
        and problem.replace_nan_values_by is None
        and problem.callback is None
        and problem.n_ieq_constr == problem.n_eq_constr == 0
    )


def _has_only_costs(out: dict[str, Any]) -> bool:
    return all(value is None or name == "F" for name, value in out.items())


def _as_float(value: Any) -> Any:
    try:
        return value.astype(np.float64)
    except (TypeError, ValueError):
        return value
