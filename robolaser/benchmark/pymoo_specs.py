"""Problems that are not calibrations: pymoo's by name, BBOB's, and the users' own, all of them as pymoo problems."""

import inspect
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from robolaser.algorithms.algorithm_spec import AlgorithmSpec
from robolaser.algorithms.user_code import imported, made_with
from robolaser.arrays import Array
from robolaser.benchmark.front import Front
from robolaser.benchmark.problem import (
    INFEASIBLE,
    OWN,
    PROBE_SEED,
    PROBES,
    TEST_FUNCTION,
    BenchmarkProblem,
    ProblemSpec,
)
from robolaser.errors import DependencyMissing, RobolaserError, UsageError, near

PYMOO, BBOB = "pymoo:", "bbob:"
TEST_FUNCTIONS = ("ackley", "griewank", "rastrigin", "rosenbrock", "schwefel", "sphere", "zakharov")
"""pymoo's test functions of any dimension whose lowest cost is known."""
DIMENSION = 10
"""Variables of a test function, unless the name says otherwise."""
FRONT_PROBES = 1000
"""Random candidates whose objectives say how far each of them ranges."""
NEGLIGIBLE = 1e-6
"""Share of a random candidate's cost that can be neglected in a user's problem."""


def _problem(name: str, make: Callable[[], Any], family: str) -> BenchmarkProblem:
    """Minimise the objectives of a pymoo problem; what violates constraints costs more than anything that does not.

    Raises:
        UsageError: It is no pymoo problem of real variables, with bounds.
    """
    from pymoo.core.problem import Problem  # noqa: PLC0415 - pymoo takes a second to import

    from robolaser.algorithms.violation import violation_of  # noqa: PLC0415

    problem = make()
    if not isinstance(problem, Problem):
        raise UsageError(
            f"{name} is {problem!r:.80}, expected a pymoo problem: its class, an instance, or a function that"
            " returns one."
        )
    if isinstance(problem.xl, dict) or not problem.has_bounds():
        raise UsageError(f"{name} needs real variables, each with a lower and an upper bound (xl and xu).")
    constraints = problem.n_ieq_constr + problem.n_eq_constr
    counted = ((problem.n_var, "variables"), (constraints, "constraints"), (problem.n_obj, "objectives"))
    many = (f"{count} {noun}" for count, noun in counted if count > (noun == "objectives"))
    title = ", ".join([_title(problem, name), *many])
    lower, upper = np.asarray(problem.xl, np.float64), np.asarray(problem.xu, np.float64)

    def cost(x: Array) -> Array:
        values = problem.evaluate(x, return_values_of=["F", "G", "H"], return_as_dictionary=True)
        f: Array = np.asarray(values["F"], np.float64)
        if constraints:
            violation, tolerated = violation_of(values)
            f = np.where(tolerated[:, None], f, INFEASIBLE * (1.0 + violation))
        return f[:, 0] if problem.n_obj == 1 else f

    front = None if problem.n_obj == 1 else _front(problem, lower, upper)
    return BenchmarkProblem(
        name,
        title,
        family,
        tuple(f"x{i}" for i in range(problem.n_var)),
        lower,
        upper,
        cost=cost,
        unit="" if front is None else "hypervolume",
        scale=1.0 if front or family == TEST_FUNCTION else _negligible(problem, lower, upper),
        lowest=_lowest(problem) if front is None else None,
        constraints=constraints,
        front=front,
    )


def named_spec(text: str) -> ProblemSpec:
    """A problem of pymoo's: `pymoo:NAME[-DIMENSION][:key=value...]`, or of BBOB: `bbob:FUNCTION[-DIMENSION]` likewise.

    Raises:
        UsageError: There is no such problem, or not with these arguments.
        DependencyMissing: `ioh` is needed and not installed.
    """
    suite = PYMOO if text.startswith(PYMOO) else BBOB
    if text == suite:
        raise _unknown(text)
    spec = AlgorithmSpec.of(text)
    function, dash, typed = str(spec.attribute).rpartition("-")
    if not dash or "^" in typed:
        function, typed = str(spec.attribute), ""
    elif not (typed.isdecimal() and int(typed) > 1):
        raise UsageError(f"{text}: '{typed}' variables, expected a whole number of at least 2: {suite}{function}-14.")
    settings: dict[str, Any] = dict(spec.settings)
    if typed:
        settings["n_var"] = int(typed)
    name = text
    if suite == BBOB or function in TEST_FUNCTIONS:
        dimension = settings.setdefault("n_var", DIMENSION)
        others = "".join(f":{key}={value}" for key, value in settings.items() if key != "n_var")
        name = f"{suite}{function}-{dimension}{others}"
    make = partial(_of_pymoo if suite == PYMOO else _of_bbob, text, function, settings)
    return _checked(name, make, TEST_FUNCTION)


def own_spec(given: object) -> ProblemSpec:
    """A user's problem: an import path with settings, `package.module:attribute[:key=value...]`, or the thing itself.

    Raises:
        UsageError: It cannot be imported, made or evaluated, or is no problem to compare on.
    """
    if isinstance(given, str):
        spec = AlgorithmSpec.of(given)
        given = imported(spec)
    else:
        spec = AlgorithmSpec(getattr(given, "__name__", type(given).__name__), "")
    return _checked(spec.text, partial(_made, spec, given), OWN)


def _checked(name: str, make: Callable[[], Any], family: str) -> ProblemSpec:
    spec = ProblemSpec(name, partial(_problem, name, make, family))
    try:
        spec.problem()
    except RobolaserError:
        raise
    except Exception as error:  # whatever a user's problem raises
        raise UsageError(f"{name} fails at random candidates ({type(error).__name__}: {error}).") from error
    return spec


def _made(spec: AlgorithmSpec, found: Any) -> Any:
    from pymoo.core.problem import Problem  # noqa: PLC0415

    return found if isinstance(found, Problem) or not callable(found) else made_with(spec, found)


def _of_pymoo(text: str, function: str, settings: Mapping[str, Any]) -> Any:
    from pymoo.problems import get_problem  # noqa: PLC0415 - pymoo takes a second to import

    try:
        return get_problem(function, **settings)
    except Exception as error:
        if str(error) == "Problem not found.":
            raise _unknown(PYMOO + function) from None
        raise UsageError(
            f"{text} cannot be made ({type(error).__name__}: {error}). Give it other arguments."
        ) from error


def _of_bbob(text: str, function: str, settings: Mapping[str, Any]) -> Any:
    """One of BBOB's 24 functions, above its lowest value."""
    from pymoo.problems.functional import FunctionalProblem  # noqa: PLC0415

    try:
        import ioh  # noqa: PLC0415 - an extra
    except ImportError:
        raise DependencyMissing(
            "BBOB comes with `ioh`, which is not installed: pip install 'robolaser[bbob]'."
        ) from None
    suite = ioh.ProblemClass.BBOB
    number = int(function) if function.isdecimal() else function
    if number not in suite.problems and number not in suite.problems.values():
        raise UsageError(f"No BBOB function '{function}'. They are numbered 1 to 24: {BBOB}15-10:instance=3.")
    unknown = settings.keys() - {"n_var", "instance"}
    if unknown:
        raise UsageError(f"{text}: no argument '{min(unknown)}'. There are n_var and instance: {BBOB}15-10:instance=3.")
    dimension = settings["n_var"]
    problem = ioh.get_problem(number, settings.get("instance", 1), dimension, suite)
    made = FunctionalProblem(
        dimension, lambda x: problem(x) - problem.optimum.y, xl=problem.bounds.lb, xu=problem.bounds.ub
    )
    made.title, made.lowest = f"BBOB's function {problem.meta_data.name}", 0.0
    return made


def _unknown(text: str) -> UsageError:
    hint = near(text, [PYMOO + name for name in TEST_FUNCTIONS])
    return UsageError(
        f"No test function '{text}'.{hint} Other names that pymoo's get_problem knows will do, too, and arguments may"
        " follow: pymoo:rastrigin-14, pymoo:ackley:a=30."
    )


def _title(problem: Any, name: str) -> str:
    if name.startswith(PYMOO):
        return f"pymoo's {name.removeprefix(PYMOO).split(':')[0].split('-')[0]} function"
    documented = inspect.cleandoc(vars(type(problem)).get("__doc__") or "")
    return getattr(problem, "title", "") or (documented.splitlines()[0].rstrip(".") if documented else name)


def _lowest(problem: Any) -> float | None:
    """The lowest cost, where the problem knows it."""
    if (stated := getattr(problem, "lowest", None)) is not None:
        return float(stated)
    front = problem.pareto_front()
    return None if front is None else float(np.min(front))


def _front(problem: Any, lower: Array, upper: Array) -> Front:
    """An empty one; it is measured by the problem's own front or, where that is not known, by random candidates."""
    try:
        known = problem.pareto_front()
    except Exception:  # some want to be told how many points, or in which directions
        known = None
    if known is not None:
        return Front.empty(len(lower), known.min(axis=0), known.max(axis=0), known)
    probes = np.random.default_rng(PROBE_SEED).uniform(lower, upper, (FRONT_PROBES, len(lower)))
    values = np.asarray(problem.evaluate(probes, return_values_of=["F"]), np.float64)
    values = values[np.isfinite(values).all(axis=1)]
    return Front.empty(len(lower), values.min(axis=0), values.max(axis=0))


def _negligible(problem: Any, lower: Array, upper: Array) -> float:
    """A difference in cost that can be neglected; the problem may state it as its `scale`."""
    if (stated := getattr(problem, "scale", None)) is not None:
        return float(stated)
    probes = np.random.default_rng(PROBE_SEED).uniform(lower, upper, (PROBES, len(lower)))
    costs = np.abs(problem.evaluate(probes, return_values_of=["F"]))
    typical = float(np.median(costs[np.isfinite(costs)])) if np.isfinite(costs).any() else 0.0
    return NEGLIGIBLE * typical or 1.0
