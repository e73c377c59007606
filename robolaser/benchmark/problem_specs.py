"""Which problems can be named: data sets, their reductions, the paper's experiment, test functions, the users' own."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from robolaser.arrays import Array
from robolaser.benchmark.problem import CALIBRATION, BenchmarkProblem, ProblemSpec
from robolaser.benchmark.pymoo_specs import BBOB, PYMOO, named_spec, own_spec
from robolaser.data.dataset import Dataset
from robolaser.data.loading import load
from robolaser.errors import BenchmarkError, UsageError
from robolaser.estimation.search_bounds import check_bounds
from robolaser.model.forward_model import Model
from robolaser.parameters import Parameters
from robolaser.problems.reduction import Reduction

PAPER, REDUCED = "paper", "reduced:"
"""Names of problems that are not folders."""
NEGLIGIBLE_M2 = 1e-12
"""Squared error of a point that can be neglected: a micrometre's."""


def spec_of(problem: object) -> ProblemSpec:
    """Find the problem that is meant.

    Args:
        problem: A folder or `paper`, with or without `reduced:`; see `pymoo_specs` for the others.

    Raises:
        UsageError: There is no such problem, it lacks bounds, or no closed form reduces it.
        BenchmarkError: It is reduced, and every parameter follows from the data in closed form.
        DataError: The data set cannot be read.
    """
    if not isinstance(problem, str):
        return own_spec(problem)
    text, whole = problem, problem.removeprefix(REDUCED)
    if ":" in whole and not Path(whole).exists():
        if whole != text:
            raise UsageError(f"{text}: only calibrations have a closed form. Leave out `reduced:`.")
        return named_spec(text) if text.startswith((PYMOO, BBOB)) else own_spec(text)
    name, dataset = _dataset(whole)
    check_bounds(Model(dataset), "compare")
    if not text.startswith(REDUCED):
        return ProblemSpec(name, partial(_calibration, name, dataset))
    if not len(Reduction(Model(dataset)).parameters):
        raise BenchmarkError(
            f"{text}: every parameter follows from the data in closed form, so nothing is left to search for."
            " Only stripe scanners have a reduced problem worth comparing on."
        )
    return ProblemSpec(REDUCED + name, partial(_reduced, REDUCED + name, dataset))


def specs_of(problems: Sequence[object]) -> tuple[ProblemSpec, ...]:
    """Find the problems that are meant; one that is named twice counts once, two of one name are a UsageError."""
    found: dict[str, tuple[object, ProblemSpec]] = {}
    for problem in dict.fromkeys(problems):
        spec = spec_of(problem)
        if spec.name in found:
            raise UsageError(
                f"{found[spec.name][0]} and {problem} are both called '{spec.name}', and results are stored by name."
                " Give one of them another `name` in its dataset.toml, or leave it out."
            )
        found[spec.name] = problem, spec
    return tuple(spec for _, spec in found.values())


def _dataset(text: str) -> tuple[str, Dataset]:
    """Name and data of a folder, or of the paper's experiment as it is simulated."""
    folder = Path(text)
    if text == PAPER and not folder.exists():
        from robolaser.robot.by_name import find_robot  # noqa: PLC0415 - only here
        from robolaser.simulation import paper  # noqa: PLC0415

        return PAPER, paper(find_robot("scorbot_er7"), seed=1).dataset
    if not folder.exists():
        raise UsageError(
            f"No folder '{text}', and no problem of that name. A problem is the folder of a data set; `paper`, the"
            " simulated experiment of Lee et al. 2004; `reduced:` before either, the search problem that its closed"
            " form leaves; a test function, as pymoo:rastrigin or bbob:15-10; or your own, package.module:attribute."
        )
    dataset = load(folder)
    return dataset.name, dataset


def _calibration(name: str, dataset: Dataset) -> BenchmarkProblem:
    """Minimise J, eq. 18, in all parameters of the sensor, within their bounds."""
    model = Model(dataset)
    return _minimised(name, model, model.parameters, lambda x: x, f"{len(model.parameters)} parameters")


def _reduced(name: str, dataset: Dataset) -> BenchmarkProblem:
    """Minimise J in the parameters that do not follow from the others in closed form; the others are optimal then."""
    reduction = Reduction(Model(dataset))
    left = reduction.parameters
    title = f"{len(left)} parameters left by the closed form"
    return _minimised(name, reduction.model, left, reduction.completed, title)


def _minimised(
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
