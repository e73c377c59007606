"""Which problems can be named: data sets, their reductions, the paper's experiment, test functions."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.problem import CALIBRATION, TEST_FUNCTION, BenchmarkProblem
from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.errors import BenchmarkError, UsageError, near
from robolaser.estimation.search_bounds import check_bounds
from robolaser.model.forward_model import Model
from robolaser.parameters import Parameters
from robolaser.problems.reduction import Reduction

PAPER, REDUCED, PYMOO = "paper", "reduced:", "pymoo:"
"""Names of problems that are not folders."""
TEST_FUNCTIONS = ("ackley", "griewank", "rastrigin", "rosenbrock", "schwefel", "sphere", "zakharov")
"""pymoo's test functions of any dimension whose lowest cost is known."""
DIMENSION = 10
"""Variables of a test function, unless the name says otherwise."""
NEGLIGIBLE_M2 = 1e-12
"""Squared error of a point that can be neglected: a micrometre's."""


class ProblemSpec(ABC):
    """Builds a problem; unlike the problem, whose functions cannot be pickled, it can be sent to another process.

    Attributes:
        name: Name of the problem.
    """

    name: str

    @abstractmethod
    def problem(self) -> BenchmarkProblem:
        """Build the problem."""


@final
@dataclass(frozen=True)
class CalibrationSpec(ProblemSpec):
    """All parameters of a data set's sensor, within their bounds."""

    name: str
    dataset: Dataset

    def problem(self) -> BenchmarkProblem:
        """Minimise J, eq. 18, in all parameters."""
        model = Model(self.dataset)
        searched = model.parameters
        return _calibration(self.name, model, searched, lambda x: x, f"{len(searched)} parameters")


@final
@dataclass(frozen=True)
class ReducedCalibrationSpec(ProblemSpec):
    """The parameters of a data set's sensor that do not follow from the others in closed form."""

    name: str
    dataset: Dataset

    def problem(self) -> BenchmarkProblem:
        """Minimise J in the remaining parameters; the others are optimal given them."""
        reduction = Reduction(Model(self.dataset))
        left = reduction.parameters
        title = f"{len(left)} parameters left by the closed form"
        return _calibration(self.name, reduction.model, left, reduction.completed, title)


@final
@dataclass(frozen=True)
class TestFunctionSpec(ProblemSpec):
    """One of pymoo's standard test functions, a sanity check because its optimum is known."""

    __test__ = False  # its name misleads pytest

    name: str
    function: str
    dimension: int

    def problem(self) -> BenchmarkProblem:
        """Minimise the function."""
        from pymoo.problems import get_problem  # noqa: PLC0415 - pymoo takes a second to import

        problem = get_problem(self.function, n_var=self.dimension)

        def cost(x: Array) -> Array:
            return np.asarray(problem.evaluate(x, return_values_of=["F"]), np.float64)[:, 0]

        return BenchmarkProblem(
            self.name,
            f"pymoo's {self.function} function, {self.dimension} variables",
            TEST_FUNCTION,
            tuple(f"x{i}" for i in range(self.dimension)),
            np.asarray(problem.xl, np.float64),
            np.asarray(problem.xu, np.float64),
            cost=cost,
            unit="",
            scale=1.0,
            lowest=float(np.asarray(problem.pareto_front())[0, 0]),
        )


def spec_of(text: str) -> ProblemSpec:
    """Read the name of a problem: a folder or `paper`, with or without `reduced:`, or `pymoo:NAME[-DIMENSION]`.

    Raises:
        UsageError: There is no such problem, or a test function with a wrong dimension or with `reduced:`; or a data
            set gives no bounds.
        BenchmarkError: It is reduced, and every parameter follows from the data in closed form.
        DataError: The data set cannot be read.
    """
    if text.startswith(PYMOO):
        return _test_function(text)
    whole = text.removeprefix(REDUCED)
    if whole.startswith(PYMOO):
        raise UsageError(f"{text}: test functions have no closed form, only calibrations have. Leave out `reduced:`.")
    name, dataset = _dataset(whole)
    check_bounds(Model(dataset), "compare")
    if not text.startswith(REDUCED):
        return CalibrationSpec(name, dataset)
    if not len(Reduction(Model(dataset)).parameters):
        raise BenchmarkError(
            f"{text}: every parameter follows from the data in closed form, so nothing is left to search for."
            " Only stripe scanners have a reduced problem worth comparing on."
        )
    return ReducedCalibrationSpec(REDUCED + name, dataset)


def specs_of(texts: Sequence[str]) -> tuple[ProblemSpec, ...]:
    """Read the names of problems; one that is named twice counts once.

    Raises:
        UsageError: Two problems have the same name.
        UsageError, BenchmarkError, DataError: As `spec_of` does.
    """
    found: dict[str, tuple[str, ProblemSpec]] = {}
    for text in dict.fromkeys(texts):
        spec = spec_of(text)
        if spec.name in found:
            raise UsageError(
                f"{found[spec.name][0]} and {text} are both called '{spec.name}', and results are stored by name."
                " Give one of them another `name` in its dataset.toml, or leave it out."
            )
        found[spec.name] = text, spec
    return tuple(spec for _, spec in found.values())


def _dataset(text: str) -> tuple[str, Dataset]:
    """Name and data of a folder, or of the paper's experiment as it is simulated."""
    folder = Path(text)
    if text == PAPER and not folder.exists():
        from robolaser.geometry.robots import find_robot  # noqa: PLC0415 - only here
        from robolaser.simulation import paper  # noqa: PLC0415

        return PAPER, paper(find_robot("scorbot_er7"), seed=1).dataset
    if not folder.exists():
        raise UsageError(
            f"No folder '{text}', and no problem of that name. A problem is the folder of a data set; `paper`, the"
            " simulated experiment of Lee et al. 2004; `reduced:` before either, the search problem that its closed"
            " form leaves; or `pymoo:` and a test function, as in pymoo:rastrigin."
        )
    dataset = load(folder)
    return dataset.name, dataset


def _test_function(text: str) -> TestFunctionSpec:
    function, dash, typed = text.removeprefix(PYMOO).partition("-")
    if function not in TEST_FUNCTIONS:
        hint = near(PYMOO + function, [PYMOO + name for name in TEST_FUNCTIONS])
        raise UsageError(
            f"No test function '{PYMOO}{function}'.{hint} A number of variables may follow: pymoo:rastrigin-14."
        )
    if dash and not (typed.isdecimal() and int(typed) > 1):
        raise UsageError(f"{text}: '{typed}' variables, expected a whole number of at least 2: pymoo:rastrigin-14.")
    dimension = int(typed) if dash else DIMENSION
    return TestFunctionSpec(f"{PYMOO}{function}-{dimension}", function, dimension)


def _calibration(
    name: str, model: Model, searched: Parameters, completed: Callable[[Array], Array], title: str
) -> BenchmarkProblem:
    """Minimise J in some parameters, given how candidates of them are completed for the whole model."""
    dataset = model.dataset
    arm = dataset.robot.name if dataset.robot else "measured flange poses"
    return BenchmarkProblem(
        name,
        f"{arm}, {len(dataset.points)} points in {len(set(dataset.points.pose.tolist()))} poses, {title}",
        CALIBRATION,
        searched.names,
        searched.lower,
        searched.upper,
        cost=lambda x: model.cost(completed(x)),
        unit="m²",
        scale=NEGLIGIBLE_M2 * len(dataset.points),
        residuals=lambda x: model.residuals(completed(x)).reshape(len(x), -1),
        model=model,
    )
