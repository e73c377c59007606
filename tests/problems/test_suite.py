"""Calibrations with known optima, to compare optimisers on."""

import numpy as np
import pytest
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.optimize import minimize
from scipy.optimize import least_squares

from robolaser.benchmark.named_problems import specs_of
from robolaser.errors import UsageError
from robolaser.estimation.multistart import multistart
from robolaser.problems import suite
from robolaser.problems.calibration_suite import DATA, FOLDER, SuiteProblem, instances

IDS = list(instances())
SLACK = 1e-6  # relative: two descents into one long valley end so near to each other


def residuals_in_units_of_the_bounds(problem: SuiteProblem):
    """Residuals (K,) as a function of the place between the bounds, (n_var,)."""
    width = problem.xu - problem.xl
    return lambda u: problem.model.residuals(problem.completed((problem.xl + u * width)[None])).ravel()


@pytest.mark.parametrize("name", IDS)
def test_the_lowest_known_cost_is_the_cost_where_it_was_found_within_the_bounds(name):
    (problem,) = suite([name])
    assert problem.evaluate(problem.best_x)[0] == pytest.approx(problem.lowest, rel=1e-9)
    assert (problem.best_x >= problem.xl).all()
    assert (problem.best_x <= problem.xu).all()


@pytest.mark.parametrize("name", IDS)
def test_another_librarys_descent_from_the_optimum_finds_nothing_lower(name):
    (problem,) = suite([name])
    u = np.clip((problem.best_x - problem.xl) / (problem.xu - problem.xl), 1e-9, 1 - 1e-9)
    end = least_squares(residuals_in_units_of_the_bounds(problem), u, bounds=(0, 1), max_nfev=20)
    assert 2 * end.cost >= problem.lowest * (1 - SLACK)


@pytest.mark.parametrize("name", ["lee2004", "ten-points", "like-views"])
def test_a_multistart_with_another_seed_finds_nothing_lower(name):
    (problem,) = suite([name])
    assert multistart(problem.model, seed=7).cost >= problem.lowest * (1 - SLACK)


@pytest.mark.parametrize("name", IDS)
def test_most_descents_are_recorded_to_fail_or_the_lowest_cost_was_reached_more_than_once(name):
    instance = instances()[name]
    assert 2 <= instance.reached <= instance.starts


def test_pymoo_minimises_it_like_any_other_problem():
    (problem,) = suite(["lee2004-reduced"])
    found = minimize(problem, DE(pop_size=20), ("n_eval", 200), seed=1)
    assert found.F[0] >= problem.lowest


def test_the_suite_has_six_to_sixty_variables_with_and_without_gauge():
    problems = list(suite())
    assert len(problems) >= 20
    assert {problem.n_var for problem in problems} >= {6, 53}
    assert all(6 <= problem.n_var <= 60 for problem in problems)
    assert any(problem.instance.held for problem in problems)


def test_the_optimum_is_not_in_the_middle_of_the_bounds():
    for problem in suite():
        place = (problem.best_x - problem.xl) / (problem.xu - problem.xl)
        assert np.abs(place - 0.5).max() > 0.1, problem.id


def test_an_unknown_instance_is_named_with_the_nearest_one():
    with pytest.raises(UsageError, match=r"no instance 'lee2005'.*lee2004"):
        next(suite(["lee2005"]))


def test_what_is_shipped_is_below_a_megabyte_and_every_measurement_brings_its_licence():
    assert sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()) < 1_000_000
    for data in DATA.iterdir():
        simulated = "simulated" in (data / "dataset.toml").read_text()
        assert simulated or list(data.glob("LICENSE*")) or (data / "package.xml").exists(), data.name


def test_compare_knows_the_suite_by_name_and_each_lowest_cost_before_any_run():
    specs = specs_of(["suite"])
    assert [spec.name for spec in specs] == [f"suite:{name}" for name in IDS]
    first = specs[0].makers[0]()
    assert (first.summary.family, first.summary.lowest) == ("calibration", instances()[IDS[0]].best)
    squares = (first.residuals(first.question.best_x[None]) ** 2).sum()
    assert squares == pytest.approx(first.summary.lowest, rel=1e-9)
