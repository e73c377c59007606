"""pymoo's genetic algorithms, made small."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, final

import numpy as np


@final
@dataclass(frozen=True)
class StockAlgorithm:
    """An algorithm that `make(crossover=…)` makes, for problems of so many objectives."""

    make: Callable[..., Any]
    n_obj: int = 2


def _single(module: str, name: str, **settings: Any) -> StockAlgorithm:
    return StockAlgorithm(_maker(f"soo.nonconvex.{module}", name, **settings), n_obj=1)


def _several(module: str, name: str, **settings: Any) -> StockAlgorithm:
    return StockAlgorithm(_maker(f"moo.{module}", name, **settings))


def _maker(module: str, name: str, **settings: Any) -> Callable[..., Any]:
    def make(**operators: Any) -> Any:
        try:
            kind = getattr(import_module(f"pymoo.algorithms.{module}"), name)
        except Exception as error:  # pymoo asks for some libraries with a plain Exception
            raise ImportError(str(error)) from error
        made = {key: value() if callable(value) else value for key, value in settings.items()}
        return kind(**made, **operators)

    return make


def _directions() -> Any:
    from pymoo.util.ref_dirs import get_reference_directions  # noqa: PLC0415 - only some algorithms need it

    return get_reference_directions("uniform", 2, n_partitions=11)


_POINTS = np.array([[0.2, 0.4], [0.5, 0.1]])

STOCK_ALGORITHMS: Mapping[str, StockAlgorithm] = {
    "GA": _single("ga", "GA", pop_size=20),
    "NicheGA": _single("ga_niching", "NicheGA", pop_size=20),
    "BRKGA": _single("brkga", "BRKGA", n_elites=6, n_offsprings=10, n_mutants=4),
    "G3PCX": _single("g3pcx", "G3PCX", pop_size=20),
    "DE": _single("de", "DE", pop_size=20),
    "NRBO": _single("nrbo", "NRBO", pop_size=20),
    "NSGA2": _several("nsga2", "NSGA2", pop_size=20),
    "DNSGA2": _several("dnsga2", "DNSGA2", pop_size=20),
    "RNSGA2": _several("rnsga2", "RNSGA2", ref_points=_POINTS, pop_size=20),
    "KGB": _several("kgb", "KGB", pop_size=20),
    "OmniOptimizer": _several("omni", "OmniOptimizer", pop_size=20),
    "SPEA2": _several("spea2", "SPEA2", pop_size=20),
    "SMSEMOA": _several("sms", "SMSEMOA", pop_size=20),
    "GDE3": _several("gde3", "GDE3", pop_size=20),
    "NSDE": _several("nsde", "NSDE", pop_size=20),
    "NSDER": _several("nsder", "NSDER", ref_dirs=_directions, pop_size=20),
    "AGEMOEA": _several("age", "AGEMOEA", pop_size=20),
    "AGEMOEA2": _several("age2", "AGEMOEA2", pop_size=20),
    "NSGA3": _several("nsga3", "NSGA3", ref_dirs=_directions),
    "UNSGA3": _several("unsga3", "UNSGA3", ref_dirs=_directions),
    "RNSGA3": _several("rnsga3", "RNSGA3", ref_points=_POINTS, pop_per_ref_point=8),
    "CTAEA": _several("ctaea", "CTAEA", ref_dirs=_directions),
    "RVEA": _several("rvea", "RVEA", ref_dirs=_directions),
    "MOEAD": _several("moead", "MOEAD", ref_dirs=_directions, n_neighbors=5),
    "ParallelMOEAD": _several("moead", "ParallelMOEAD", ref_dirs=_directions, n_neighbors=5),
}
"""By pymoo's names."""
