"""Where questions come from: data sets, what their closed forms leave over, the paper's experiment, test functions."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.problem import CALIBRATION, TEST_FUNCTION, Question
from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.errors import (
    DimensionSenseless,
    NoClosedForm,
    NothingToSearch,
    ProblemTwice,
    ProblemUnknown,
    TestFunctionUnknown,
)
from robolaser.problems.reduction import Reduction
from robolaser.model.forward_model import Model
from robolaser.parameters import Parameters

PAPER, REDUCED, PYMOO = "paper", "reduced:", "pymoo:"
"""How problems that are no folders are asked for."""
TEST_FUNCTIONS = ("ackley", "griewank", "rastrigin", "rosenbrock", "schwefel", "sphere", "zakharov")
"""Of pymoo's, those of any dimension whose lowest cost is known."""
DIMENSION = 10
"""Of a test function, if none is asked for."""
NEGLIGIBLE_M2 = 1e-12
"""Of a point's squared error: a micrometre."""


class Source(ABC):
    """Makes a question; can be sent to another process or machine, where the question, a tangle of functions, cannot.

    Attributes:
        name: Of the question.
    """

    name: str

    @abstractmethod
    def question(self) -> Question:
        """Make it."""


@final
@dataclass(frozen=True)
class Calibration(Source):
    """All parameters of a data set's sensor, within their bounds."""

    name: str
    dataset: Dataset

    def question(self) -> Question:
        """Minimise J, eq. 18, in all parameters."""
        model = Model(self.dataset)
        searched = model.parameters
        return _calibration(self.name, model, searched, lambda x: x, f"{len(searched)} parameters")


@final
@dataclass(frozen=True)
class ReducedCalibration(Source):
    """Those parameters of a data set's sensor that do not follow from the others in closed form."""

    name: str
    dataset: Dataset

    def question(self) -> Question:
        """Minimise J in the parameters that are left, the others the best for them."""
        reduction = Reduction(Model(self.dataset))
        left = reduction.parameters
        words = f"{len(left)} parameters left by the closed form"
        return _calibration(self.name, reduction.model, left, reduction.completed, words)


@final
@dataclass(frozen=True)
class TestFunction(Source):
    """One of pymoo's standard test functions: a sanity check, for what is known of it."""

    __test__ = False  # its name misleads pytest

    name: str
    function: str
    dimension: int

    def question(self) -> Question:
        """Minimise it."""
        from pymoo.problems import get_problem  # noqa: PLC0415 - pymoo takes a second to import

        problem = get_problem(self.function, n_var=self.dimension)

        def cost(x: Array) -> Array:
            return np.asarray(problem.evaluate(x, return_values_of=["F"]), np.float64)[:, 0]

        return Question(
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


def source(text: str) -> Source:
    """What a problem's text stands for: a folder or `paper`, perhaps after `reduced:`, or `pymoo:NAME[-DIMENSION]`.

    Raises:
        ProblemUnknown: It stands for nothing.
        TestFunctionUnknown, DimensionSenseless: pymoo has none of that name, or not with so many variables.
        NoClosedForm: Reduced, and a test function.
        NothingToSearch: Reduced, and every parameter follows from the data in closed form.
        RobolaserError: The data set is not right.
    """
    if text.startswith(PYMOO):
        return _test_function(text)
    whole = text.removeprefix(REDUCED)
    if whole.startswith(PYMOO):
        raise NoClosedForm(text)
    if not text.startswith(REDUCED):
        return Calibration(*_dataset(whole))
    name, dataset = _dataset(whole)
    if not len(Reduction(Model(dataset)).parameters):
        raise NothingToSearch(text)
    return ReducedCalibration(REDUCED + name, dataset)


def sources(texts: Sequence[str]) -> tuple[Source, ...]:
    """What problems' texts stand for; one that is named twice is asked once.

    Raises:
        ProblemTwice: Two of them have the same name.
        RobolaserError: As `source` does.
    """
    found: dict[str, tuple[str, Source]] = {}
    for text in dict.fromkeys(texts):
        one = source(text)
        if one.name in found:
            raise ProblemTwice(one.name, found[one.name][0], text)
        found[one.name] = text, one
    return tuple(one for _, one in found.values())


def _dataset(text: str) -> tuple[str, Dataset]:
    """Name and data of a folder, or of the paper's experiment as it is simulated."""
    folder = Path(text)
    if text == PAPER and not folder.exists():
        from robolaser.geometry.robots import find_robot  # noqa: PLC0415 - only here
        from robolaser.simulation import paper  # noqa: PLC0415

        return PAPER, paper(find_robot("scorbot_er7"), seed=1).dataset
    if not folder.exists():
        raise ProblemUnknown(text)
    dataset = load(folder)
    return dataset.name, dataset


def _test_function(text: str) -> TestFunction:
    function, dash, typed = text.removeprefix(PYMOO).partition("-")
    if function not in TEST_FUNCTIONS:
        raise TestFunctionUnknown(PYMOO + function, [PYMOO + name for name in TEST_FUNCTIONS])
    if dash and not (typed.isdecimal() and int(typed) > 1):
        raise DimensionSenseless(text, typed)
    dimension = int(typed) if dash else DIMENSION
    return TestFunction(f"{PYMOO}{function}-{dimension}", function, dimension)


def _calibration(
    name: str, model: Model, searched: Parameters, completed: Callable[[Array], Array], words: str
) -> Question:
    """Minimise J in some parameters, given how candidates of them become candidates of the whole model."""
    dataset = model.dataset
    arm = dataset.robot.name if dataset.robot else "measured flange poses"
    return Question(
        name,
        f"{arm}, {len(dataset.points)} points in {len(set(dataset.points.pose.tolist()))} poses, {words}",
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
