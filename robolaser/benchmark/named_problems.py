"""Problems by name: data sets, the paper's experiment, test functions, and problems of users."""

import copy
import re
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pymoo.core.problem import Problem
from pymoo.problems import get_problem
from pymoo.problems.dyn import DynamicProblem
from pymoo.problems.functional import FunctionalProblem

from robolaser.algorithms.registry import reference_directions
from robolaser.algorithms.spec import AlgorithmSpec
from robolaser.algorithms.user_code import Given, by_name, copies, imported, made, named, title_of
from robolaser.arrays import Array
from robolaser.benchmark.problem import BenchmarkProblem, Family, ProblemSpec, ProblemSummary
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import evenly
from robolaser.errors import BenchmarkError, RobolaserError, UsageError, near
from robolaser.plugins import extra

PAPER, REDUCED, SUITE, PYMOO, BBOB = "paper", "reduced:", "suite", "pymoo:", "bbob:"
NEGLIGIBLE_M2 = 1e-12  # negligible squared error of a point: a micrometre's
TEST_FUNCTIONS = ("ackley", "griewank", "rastrigin", "rosenbrock", "schwefel", "sphere", "zakharov")
"""pymoo's test functions of any dimension whose lowest cost is known."""
DIMENSION = 10  # variables of a test function, unless its name states them
FRONT_POINTS = 500  # points of a known front for distances
COUNTS = ("n_var", "n_obj")  # settings of test functions that count something
UNKNOWN = re.compile(r"unexpected keyword argument '(\w+)'")  # Python's words for a setting that a function lacks
RANGE = re.compile(r":instance=(\d+)\.\.(\d+)")


def specs_of(problems: Given) -> tuple[ProblemSpec, ...]:
    """Find problems by name, or name given pymoo problems.

    Raises:
        UsageError: There is no such problem, it cannot be made, or two have one name.
        BenchmarkError: It is reduced, and every parameter follows from the data in closed form.
        DataError: A data set cannot be read.
    """
    if not isinstance(problems, Mapping) and SUITE in problems:
        from robolaser.problems import suite  # noqa: PLC0415 - test functions need no models

        at, whole = problems.index(SUITE), [f"{SUITE}:{one}" for one in suite().ids]
        problems = [*problems[:at], *whole, *problems[at + 1 :]]
    hint = 'compare({"small": …, "large": …}, …); a data set by the `name` in its dataset.toml'
    return tuple(by_name(problems, _found, hint).values())


def _found(given: object, name: str) -> ProblemSpec:
    if isinstance(given, Dataset):
        return _checked(name or given.name, partial(_calibration, name or given.name, given, reduced=False))
    if not isinstance(given, str | Path):
        return _own(given, name)
    text = str(given)
    if text.startswith(f"{SUITE}:"):
        return _checked(name or text, partial(_of_suite, name or text, text.removeprefix(f"{SUITE}:")))
    whole = text.removeprefix(REDUCED)
    if ":" in whole and not Path(whole).exists():
        if whole != text:
            raise UsageError(f"{text}: only calibrations have a closed form. Leave out `reduced:`.")
        instances = RANGE.search(text)
        if instances is not None:
            low, high = int(instances[1]), int(instances[2])
            if low > high:
                raise UsageError(f"{text}: there is no instance from {low} to {high}.")
            name = name or RANGE.sub("", text)
            of_each = [_found(RANGE.sub(f":instance={i}", text), name) for i in range(low, high + 1)]
            return ProblemSpec(name, tuple(spec.makers[0] for spec in of_each))
        return _function(text, name) if text.startswith((PYMOO, BBOB)) else _own(text, name)
    found, dataset = _dataset(whole)
    reduced = text != whole
    name = name or (REDUCED + found if reduced else found)
    return _checked(name, partial(_calibration, name, dataset, reduced=reduced))


def _dataset(text: str) -> tuple[str, Any]:
    """Name and data of a folder, or of the paper's simulated experiment."""
    from robolaser.data.loading import load  # noqa: PLC0415

    folder = Path(text)
    if text == PAPER and not folder.exists():
        from robolaser.robot.by_name import find_robot  # noqa: PLC0415 - only here
        from robolaser.simulation import paper  # noqa: PLC0415

        return PAPER, paper(find_robot("scorbot_er7"), seed=1).dataset
    if not folder.exists():
        raise UsageError(
            f"No folder '{text}', and no problem of that name. A problem is the folder of a data set; `paper`, the"
            " simulated experiment of Lee et al. 2004; `reduced:` before either, the search problem that its closed"
            " form leaves; `suite`, calibrations whose optima are known; a test function, as pymoo:rastrigin or"
            " bbob:15-10; or your own, package.module:attribute."
        )
    dataset = load(folder)
    return dataset.name, dataset


def _calibration(name: str, dataset: Any, *, reduced: bool) -> BenchmarkProblem:
    """Minimise J, eq. 18, within bounds: in all parameters, or in those that do not follow from others."""
    from robolaser.estimation.multistart import check_bounds  # noqa: PLC0415 - test functions need no models
    from robolaser.model.forward_model import Model  # noqa: PLC0415
    from robolaser.problems import ReducedCalibration, ScannerCalibration  # noqa: PLC0415

    check_bounds(model := Model(dataset), "compare")
    question = ReducedCalibration(model) if reduced else ScannerCalibration(dataset)
    if not question.n_var:
        raise BenchmarkError(
            f"{name}: every parameter follows from the data in closed form, so nothing is left to search for."
            " Only stripe scanners have a reduced problem worth comparing on."
        )
    return _of_model(name, question, "parameters left by the closed form" if reduced else "parameters")


def _of_suite(name: str, which: str) -> BenchmarkProblem:
    from robolaser.problems import suite  # noqa: PLC0415 - test functions need no models

    question = suite()[which]
    return _of_model(name, question, f"parameters: {question.title}", question.lowest)


def _of_model(name: str, question: Any, variables: str, lowest: float | None = None) -> BenchmarkProblem:
    model, dataset = question.model, question.model.dataset
    completed = getattr(question, "completed", np.asarray)
    arm = dataset.robot.name if dataset.robot else "measured flange poses"
    summary = ProblemSummary(
        name,
        f"{arm}, {len(dataset.points)} points in {len(set(dataset.points.pose.tolist()))} poses,"
        f" {question.n_var} {variables}",
        "calibration",
        question.n_var,
        1,
        "m²" if model.blocks.unit == "m" else f"{model.blocks.unit}²",
        floor=NEGLIGIBLE_M2 * len(dataset.points),
        lowest=lowest,
        found_by="robolaser's own search",
    )
    return BenchmarkProblem(summary, question, lambda x: model.residuals(completed(x)).reshape(len(x), -1), model)


def _function(text: str, name: str) -> ProblemSpec:
    """`pymoo:NAME[-DIMENSION][:key=value...]`, or `bbob:FUNCTION[-DIMENSION]` likewise."""
    suite = PYMOO if text.startswith(PYMOO) else BBOB
    if text == suite:
        raise _unknown(text)
    spec = AlgorithmSpec.of(text)
    function, dash, typed = str(spec.attribute).rpartition("-")
    if not dash or "^" in typed:
        function, typed = str(spec.attribute), ""
    elif not (typed.isdecimal() and int(typed) > 1):
        raise UsageError(f"{text}: '{typed}' variables, expected a whole number of at least 2: {suite}{function}-14.")
    settings: dict[str, Any] = dict(spec.values)
    for key, value in settings.items():
        if key in COUNTS and (type(value) is not int or value < 1):
            raise UsageError(f"{text}: {key} is {value}, expected a whole number of at least 1.")
    if typed and settings.setdefault("n_var", int(typed)) != int(typed):
        raise UsageError(f"{text}: {typed} and {settings['n_var']} variables. State one number.")
    if suite == BBOB or function in TEST_FUNCTIONS:
        dimension = settings.setdefault("n_var", DIMENSION)
        others = "".join(f":{key}={value}" for key, value in settings.items() if key != "n_var")
        text = f"{suite}{function}-{dimension}{others}"
    make = partial(_pymoos if suite == PYMOO else _bbobs, text, function, settings)
    return _checked(name or text, partial(_built, name or text, make, "test function"))


def _own(given: object, name: str) -> ProblemSpec:
    """A user's problem: an import path with settings, or an object, which is sent to workers."""
    if isinstance(given, str):
        spec = AlgorithmSpec.of(given)
        name, found = name or given, imported(spec)
    else:
        name = name or getattr(given, "__name__", type(given).__name__)
        spec, found = AlgorithmSpec(name, name), given
    is_instance = isinstance(found, Problem) or not callable(found)
    make = copies(spec, found) if is_instance else partial(copy.deepcopy, made(spec, found, spec.values))
    return _checked(name, partial(_built, name, make, "own problem"))


def _checked(name: str, make: Callable[[], BenchmarkProblem]) -> ProblemSpec:
    try:
        make()
    except RobolaserError:
        raise
    except Exception as error:  # of a user's problem
        raise UsageError(f"{name} cannot be made ({type(error).__name__}: {error}).") from error
    return ProblemSpec(name, (make,))


def _built(name: str, make: Callable[[], Any], family: Family) -> BenchmarkProblem:
    """A pymoo problem with its properties, checked to have bounds and not to change with time."""
    problem = make()
    if not isinstance(problem, Problem):
        raise UsageError(
            f"{name} is {named(problem)}, expected a pymoo problem: its class, an instance, or a function that"
            " returns one."
        )
    if isinstance(problem, DynamicProblem):
        raise UsageError(f"{name} changes with time, and every run would see it at another one: it cannot be compared.")
    is_mixed = getattr(problem, "vars", None) is not None
    if not (is_mixed or (problem.has_bounds() and np.isfinite([problem.xl, problem.xu]).all())):
        raise UsageError(f"{name} needs a finite lower and upper bound for each variable (xl and xu).")
    constraints = problem.n_ieq_constr + problem.n_eq_constr
    counted = ((problem.n_var, "variables"), (constraints, "constraints"), (problem.n_obj, "objectives"))
    many = (f"{count} {noun}" for count, noun in counted if count > (noun == "objectives"))
    known, lowest, front = _front(problem), getattr(problem, "lowest", None), None
    if problem.n_obj > 1:
        family, lowest, front = "several objectives", None, known
    elif lowest is None and known is not None:
        lowest = known.min()
    summary = ProblemSummary(
        name,
        ", ".join([_title(problem, name), *many]),
        family,
        problem.n_var,
        problem.n_obj,
        lowest=None if lowest is None else float(lowest),
        front=None if front is None else front.tolist(),
        found_by="" if lowest is None else "theory",
    )
    return BenchmarkProblem(summary, problem)


def _front(problem: Any) -> Array | None:
    """The theoretical best front, thinned evenly; None where it is not known."""
    try:
        known = problem.pareto_front()
    except Exception:  # some need reference directions
        try:
            known = problem.pareto_front(reference_directions(problem.n_obj))
        except Exception:
            known = None
    if known is None or not np.isfinite(known := np.atleast_2d(np.asarray(known, np.float64))).all():
        return None
    return np.asarray(known[evenly(len(known), FRONT_POINTS)])


def _pymoos(text: str, function: str, settings: Mapping[str, Any]) -> Any:
    try:
        problem = get_problem(function, **settings)
        if function == "zdt5":
            problem.vtype = bool  # its variables are bits, which pymoo does not state
        return problem
    except Exception as error:
        if str(error) == "Problem not found.":
            raise _unknown(PYMOO + function) from None
        if unknown := UNKNOWN.search(str(error)):
            raise UsageError(f"{PYMOO}{function} has no setting '{unknown[1]}'. Leave it out.") from None
        raise UsageError(
            f"{text} cannot be made ({type(error).__name__}: {error}). Give it other arguments."
        ) from error


def _bbobs(text: str, function: str, settings: Mapping[str, Any]) -> Any:
    """One of BBOB's 24 functions, above its lowest value."""
    ioh = extra("ioh", "BBOB comes with `ioh`, which is not installed: pip install 'robolaser[bbob]'.")
    suite = ioh.ProblemClass.BBOB
    number = int(function) if function.isdecimal() else function
    if number not in suite.problems and number not in suite.problems.values():
        raise UsageError(f"No BBOB function '{function}'. They are numbered 1 to 24: {BBOB}15-10:instance=3.")
    if unknown := settings.keys() - {"n_var", "instance"}:
        raise UsageError(f"{text}: no argument '{min(unknown)}'. There are n_var and instance: {BBOB}15-10:instance=3.")
    problem = ioh.get_problem(number, settings.get("instance", 1), settings["n_var"], suite)
    bounds, optimum = problem.bounds, problem.optimum.y
    found = FunctionalProblem(settings["n_var"], lambda x: problem(x) - optimum, xl=bounds.lb, xu=bounds.ub)
    found.title, found.lowest = f"BBOB's function {problem.meta_data.name}", 0.0
    return found


def _unknown(text: str) -> UsageError:
    hint = near(text, [PYMOO + name for name in TEST_FUNCTIONS])
    return UsageError(
        f"No test function '{text}'.{hint} Other names that pymoo's get_problem knows will do, too, and arguments may"
        " follow: pymoo:rastrigin-14, pymoo:ackley:a=30."
    )


def _title(problem: Any, name: str) -> str:
    if name.startswith(PYMOO):
        return f"pymoo's {name.removeprefix(PYMOO).split(':')[0].split('-')[0]} function"
    return getattr(problem, "title", "") or title_of(problem, name)
