"""Violation of the constraints by many candidates at once, as pymoo's individuals compute it."""

from typing import Any

import numpy as np
from pymoo.core.individual import Individual, constr_to_cv

from robolaser.arrays import Array, Bools


def violation_of(values: dict[str, Any]) -> tuple[Array, Bools]:
    """Violation, (n, 1), and whether pymoo tolerates it, (n,).

    Args:
        values: Values of n candidates: of G (n, g), which is to be at most 0, H (n, h), which is to be 0,
            and CV (n, 1), the violation itself, those that there are.
    """
    config = Individual.default_config()
    if "CV" in values:
        violation = np.asarray(values["CV"], np.float64)[:, 0]
    else:
        G = _each(values["G"], config["cv_ieq"]) if "G" in values else 0.0
        H = _each(np.abs(values["H"]), config["cv_eq"]) if "H" in values else 0.0
        violation = np.asarray(G + H, np.float64)
    return violation[:, None], violation <= config.get("cv_eps", 0.0)


def _each(excess: Array, rule: dict[str, Any]) -> Array:
    if rule["func"] is np.sum:
        return np.asarray(constr_to_cv(excess, **{**rule, "func": lambda rows: rows.sum(axis=1)}))
    return np.array([constr_to_cv(row, **rule) for row in excess])
