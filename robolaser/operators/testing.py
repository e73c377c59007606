"""Tests whether any operator keeps the contract of pymoo's algorithms, and which of them it serves.

from robolaser.operators.testing import check_operator

print(check_operator(MyCrossover()))
"""

import copy
import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import SimpleNamespace
from typing import Any, final

import numpy as np
from pymoo.core.crossover import Crossover
from pymoo.core.mutation import Mutation
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.selection import Selection
from pymoo.core.survival import Survival
from pymoo.core.termination import NoTermination
from pymoo.optimize import minimize
from pymoo.util.ref_dirs import get_reference_directions

from robolaser.arrays import Array
from robolaser.errors import AlgorithmError

SLOTS = {Crossover: "crossover", Mutation: "mutation", Selection: "selection", Survival: "survival"}
"""The argument of pymoo's algorithms for an operator, by its base class."""

WORKS, REFUSED, FAILS, IGNORED, NO_PLACE = "works", "refused", "fails", "ignored", "no place"
MISSING = "not installed"  # required by the algorithm itself

_DIRECTIONS = get_reference_directions("uniform", 2, n_partitions=11)
_POINTS = np.array([[0.2, 0.4], [0.5, 0.1]])
_SMALL = {"pop_size": 20}
STOCK_ALGORITHMS: Mapping[str, tuple[str, Mapping[str, Any]]] = {
    "GA": ("soo.nonconvex.ga", _SMALL),
    "NicheGA": ("soo.nonconvex.ga_niching", _SMALL),
    "BRKGA": ("soo.nonconvex.brkga", {"n_elites": 6, "n_offsprings": 10, "n_mutants": 4}),
    "G3PCX": ("soo.nonconvex.g3pcx", _SMALL),
    "DE": ("soo.nonconvex.de", _SMALL),
    "NRBO": ("soo.nonconvex.nrbo", _SMALL),
    "NSGA2": ("moo.nsga2", _SMALL),
    "DNSGA2": ("moo.dnsga2", _SMALL),
    "RNSGA2": ("moo.rnsga2", {"ref_points": _POINTS, "pop_size": 20}),
    "KGB": ("moo.kgb", _SMALL),
    "OmniOptimizer": ("moo.omni", _SMALL),
    "SPEA2": ("moo.spea2", _SMALL),
    "SMSEMOA": ("moo.sms", _SMALL),
    "GDE3": ("moo.gde3", _SMALL),
    "NSDE": ("moo.nsde", _SMALL),
    "NSDER": ("moo.nsder", {"ref_dirs": _DIRECTIONS, "pop_size": 20}),
    "AGEMOEA": ("moo.age", _SMALL),
    "AGEMOEA2": ("moo.age2", _SMALL),
    "NSGA3": ("moo.nsga3", {"ref_dirs": _DIRECTIONS}),
    "UNSGA3": ("moo.unsga3", {"ref_dirs": _DIRECTIONS}),
    "RNSGA3": ("moo.rnsga3", {"ref_points": _POINTS, "pop_per_ref_point": 8}),
    "CTAEA": ("moo.ctaea", {"ref_dirs": _DIRECTIONS}),
    "RVEA": ("moo.rvea", {"ref_dirs": _DIRECTIONS}),
    "MOEAD": ("moo.moead", {"ref_dirs": _DIRECTIONS, "n_neighbors": 5}),
    "ParallelMOEAD": ("moo.moead", {"ref_dirs": _DIRECTIONS, "n_neighbors": 5}),
}
"""pymoo's genetic algorithms by name: the module in `pymoo.algorithms`, and settings that make them small."""


@final
class Bowl(Problem):
    """Squares of the distances to a point, with bounds of every kind: wide, narrow, one without room."""

    def __init__(self, n_obj: int = 1) -> None:
        lower, upper = np.array([-1.0, 0.0, 5.0, 2.0, -1e-9]), np.array([1.0, 1e6, 5.5, 2.0, 1e-9])
        super().__init__(n_var=5, n_obj=n_obj, xl=lower, xu=upper)

    def _evaluate(self, X: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        y = (X - self.xl) / np.where(self.xu > self.xl, self.xu - self.xl, 1.0)
        out["F"] = np.stack([((y - 0.3 * i - 0.2) ** 2).sum(axis=1) for i in range(self.n_obj)], axis=1)


@final
@dataclass(frozen=True)
class Compatibility:
    """The result of `check_operator`."""

    operator: str
    slot: str
    algorithms: Mapping[str, tuple[str, str]]
    """By algorithm: "works", "refused" in a sentence of ours, which follows, "fails", "ignored", "no place" or
    "not installed"."""

    def __str__(self) -> str:
        """A line for each algorithm."""
        rows = [f"{name:14} {outcome}{': ' if why else ''}{why}" for name, (outcome, why) in self.algorithms.items()]
        return "\n".join([f"{self.operator}, a {self.slot}, keeps to the contract.", *rows])


def check_operator(operator: Any, *, algorithms: Iterable[str] = STOCK_ALGORITHMS) -> Compatibility:
    """Try an operator against the contract, then in each stock algorithm of pymoo's.

    The contract: the same seed gives the same outcome, from `random_state` alone; parents do not change; children stay
    within the bounds and have the right shape.

    Args:
        operator: A crossover, mutation, selection or survival of pymoo's.
        algorithms: Names of those to try, of `STOCK_ALGORITHMS`.

    Raises:
        AlgorithmError: It is no operator, or it breaks the contract; the message names the fault.
    """
    slot = _slot(operator)
    name = type(operator).__name__
    for law in LAWS:
        try:
            broken = law(copy.deepcopy(operator))
        except Exception as error:  # any exception of a user's operator
            raise AlgorithmError(f"{name} failed where it was tried: {type(error).__name__}: {error}") from error
        if broken:
            raise AlgorithmError(f"{name} {broken}.")
    return Compatibility(name, slot, {each: _outcome(operator, slot, each) for each in algorithms})


def _act(operator: Any, pop: Any, seed: int) -> Array:
    """One call, as by pymoo's algorithms -> its result: genes, or the indices of the selected."""
    problem = Bowl()
    algorithm = SimpleNamespace(n_iter=3, termination=NoTermination())
    given = {"random_state": np.random.default_rng(seed), "algorithm": algorithm}
    match _slot(operator):
        case "crossover":
            pairs = np.arange(len(pop)).reshape(-1, operator.n_parents)
            found = operator.do(problem, pop, pairs, **given).get("X")
        case "mutation":
            found = operator.do(problem, pop, inplace=False, **given).get("X")
        case "selection":
            found = operator.do(problem, pop, 10, 2, to_pop=False, **given)
        case _:
            found = operator.do(problem, pop, n_survive=len(pop) // 2, **given).get("X")
    return np.asarray(found)


def evaluated_population(n: int = 60) -> Any:
    """Individuals uniform in the bounds of `Bowl`, some on the bounds, evaluated."""
    problem, rng = Bowl(), np.random.default_rng(0)
    X = rng.uniform(problem.xl, problem.xu, (n, problem.n_var))
    X = np.where(rng.random(X.shape) < 0.1, problem.xl, np.where(rng.random(X.shape) < 0.1, problem.xu, X))
    return Population.new(X=X, F=problem.evaluate(X, return_values_of=["F"]))


def _slot(operator: Any) -> str:
    for base, slot in SLOTS.items():
        if isinstance(operator, base):
            return slot
    raise AlgorithmError(
        f"{operator!r} is not an operator: expected an instance of pymoo's Crossover, Mutation, Selection or Survival."
    )


def _repeats(operator: Any) -> str | None:
    pop = evaluated_population()
    same = np.array_equal(_act(operator, pop, 7), _act(copy.deepcopy(operator), pop, 7))
    return None if same else "gives another outcome with the same seed: draw from `random_state` alone"


def _leaves_parents_alone(operator: Any) -> str | None:
    pop = evaluated_population()
    X, F = pop.get("X").copy(), pop.get("F").copy()
    _act(operator, pop, 7)
    same = np.array_equal(pop.get("X"), X) and np.array_equal(pop.get("F"), F)
    return None if same else "changes the parents it is given: work on a copy"


def _keeps_to_the_bounds(operator: Any) -> str | None:
    problem, pop = Bowl(), evaluated_population()
    slot = _slot(operator)
    for seed in range(20):
        found = _act(operator, pop, seed)
        if slot == "selection":
            if found.shape != (10, 2) or not np.issubdtype(found.dtype, np.integer):
                return f"selects an array {found.shape} of {found.dtype}; expected were indices (n_select, n_parents)"
        elif not np.all((found >= problem.xl) & (found <= problem.xu)):
            gene = int(np.argwhere(~((found >= problem.xl) & (found <= problem.xu)))[0, 1])
            return f"leaves the bounds, in variable {gene}: clip, or repair"
    return None


LAWS: tuple[Callable[[Any], str | None], ...] = (_repeats, _leaves_parents_alone, _keeps_to_the_bounds)
"""Each returns how an operator breaks it, or None."""


def _outcome(operator: Any, slot: str, name: str) -> tuple[str, str]:
    """Run an algorithm with the operator in its place, twice."""
    module, settings = STOCK_ALGORITHMS[name]
    calls, n_obj = [0], 1 if module.startswith("soo.") else 2
    try:
        kind = _class(module, name)
        algorithms = [kind(**settings, **{slot: _counted(operator, calls)}) for _ in range(2)]
    except ImportError as error:
        return MISSING, str(error)
    except Exception:  # each in its own way
        return NO_PLACE, ""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            X, again = (minimize(Bowl(n_obj), each, ("n_gen", 5), seed=1).pop.get("X") for each in algorithms)
        except AlgorithmError as error:
            return REFUSED, str(error)
        except Exception as error:  # an algorithm or an operator may raise anything
            return FAILS, f"{type(error).__name__}: {error}"
    if not calls[0]:
        return IGNORED, ""
    return (WORKS, "") if np.array_equal(X, again) else (FAILS, "two runs of the same seed differ")


def _class(module: str, name: str) -> Any:
    try:
        return getattr(import_module(f"pymoo.algorithms.{module}"), name)
    except Exception as error:  # pymoo reports some missing libraries by a plain Exception
        raise ImportError(str(error)) from error


def _counted(operator: Any, calls: list[int]) -> Any:
    """A copy that counts its calls, copied further or not."""
    counted = copy.deepcopy(operator)
    do = counted._do

    def count(*args: Any, **kwargs: Any) -> Any:
        calls[0] += 1
        return do(*args, **kwargs)

    counted._do = count
    return counted
