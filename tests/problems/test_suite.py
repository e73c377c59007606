"""Calibrations with known optima, to compare optimisers on."""

import importlib.util

import numpy as np
import pytest
from pymoo.algorithms.soo.nonconvex.de import DE
from pymoo.optimize import minimize
from scipy.optimize import least_squares

from robolaser.benchmark.named_problems import specs_of
from robolaser.errors import DependencyMissing, UsageError
from robolaser.estimation.multistart import multistart
from robolaser.problems import suite
from robolaser.problems.calibration_suite import DATA, FOLDER, SuiteProblem

IDS = suite().ids
SLACK = 1e-6  # relative: two descents into one long valley end so near to each other


def residuals_in_units_of_the_bounds(problem: SuiteProblem):
    """Residuals (K,) as a function of the place between the bounds, (dimension,)."""
    width = problem.xu - problem.xl
    return lambda u: problem.model.residuals(problem.completed((problem.xl + u * width)[None])).ravel()


@pytest.mark.parametrize("name", IDS)
def test_the_lowest_known_cost_is_the_cost_where_it_was_found_within_the_bounds(name):
    problem = suite()[name]
    assert problem(problem.best_x) == pytest.approx(problem.lowest, rel=1e-9)
    assert (problem.best_x >= problem.xl).all()
    assert (problem.best_x <= problem.xu).all()


@pytest.mark.parametrize("name", IDS)
def test_another_librarys_descent_from_the_optimum_finds_nothing_lower(name):
    problem = suite()[name]
    u = np.clip((problem.best_x - problem.xl) / (problem.xu - problem.xl), 1e-9, 1 - 1e-9)
    end = least_squares(residuals_in_units_of_the_bounds(problem), u, bounds=(0, 1), max_nfev=20)
    assert 2 * end.cost >= problem.lowest * (1 - SLACK)


@pytest.mark.parametrize("name", ["lee2004", "ten-points", "like-views"])
def test_a_multistart_with_another_seed_finds_nothing_lower(name):
    problem = suite()[name]
    assert multistart(problem.model, seed=7).cost >= problem.lowest * (1 - SLACK)


@pytest.mark.parametrize("name", IDS)
def test_most_descents_are_recorded_to_fail_or_the_lowest_cost_was_reached_more_than_once(name):
    instance = suite()[name].instance
    assert 2 <= instance.reached <= instance.starts


def test_a_loop_written_for_coco_runs():
    seen = []
    for problem in suite(["lee2004", "ur5-tracker"]):
        rng = np.random.default_rng(1)
        x, lowest = problem.initial_solution, np.inf
        while problem.evaluations < 10 * problem.dimension and not problem.final_target_hit:
            lowest = min(lowest, problem(x))
            x = rng.uniform(problem.lower_bounds, problem.upper_bounds)
        assert problem.best_observed_fvalue1 == lowest
        assert not problem.final_target_hit
        problem(problem.best_x)
        assert problem.final_target_hit
        seen.append((problem.id, problem.evaluations))
    assert seen == [("lee2004", 141), ("ur5-tracker", 91)]


def test_pymoo_minimises_it_like_any_other_problem_and_every_candidate_is_counted():
    problem = suite()["lee2004-reduced"]
    found = minimize(problem, DE(pop_size=20), ("n_eval", 200), seed=1, copy_algorithm=False)
    assert found.F[0] >= problem.lowest
    assert problem.evaluations == 200


def test_problems_are_new_each_time_so_that_runs_do_not_share_their_count():
    calibrations = suite()
    calibrations[0](calibrations[0].best_x)
    assert calibrations[0].evaluations == 0


def test_the_suite_has_six_to_sixty_variables_with_and_without_gauge():
    problems = list(suite())
    assert len(problems) >= 20
    assert {problem.dimension for problem in problems} >= {6, 53}
    assert all(6 <= problem.dimension <= 60 for problem in problems)
    assert any(problem.instance.held for problem in problems)


def test_the_optimum_is_not_in_the_middle_of_the_bounds():
    for problem in suite():
        place = (problem.best_x - problem.xl) / (problem.xu - problem.xl)
        assert np.abs(place - 0.5).max() > 0.1, problem.id


def test_an_unknown_instance_is_named_with_the_nearest_one():
    with pytest.raises(UsageError, match=r"no instance 'lee2005'.*lee2004"):
        suite(["lee2005"])


def test_what_is_shipped_is_below_a_megabyte_and_every_measurement_brings_its_licence():
    assert sum(path.stat().st_size for path in FOLDER.rglob("*") if path.is_file()) < 1_000_000
    for data in DATA.iterdir():
        simulated = "simulated" in (data / "dataset.toml").read_text()
        assert simulated or list(data.glob("LICENSE*")) or (data / "package.xml").exists(), data.name


def test_a_logger_of_ioh_writes_the_run(tmp_path):
    ioh = pytest.importorskip("ioh")
    problem = suite()["lee2004"]
    wrapped = problem.as_ioh()
    logger = ioh.logger.Analyzer(root=str(tmp_path), folder_name="run", algorithm_name="random")
    wrapped.attach_logger(logger)
    rng = np.random.default_rng(1)
    for _ in range(20):
        wrapped(rng.random(problem.dimension))
    at_best = wrapped(wrapped.optimum.x)
    logger.close()
    assert at_best == pytest.approx(problem.lowest, rel=1e-6)
    assert problem.evaluations == 21
    assert "robolaser-lee2004" in next(tmp_path.rglob("*.json")).read_text()
    assert list(tmp_path.rglob("*.dat"))


@pytest.mark.skipif(importlib.util.find_spec("ioh") is not None, reason="ioh is installed")
def test_without_ioh_the_error_says_what_to_install():
    with pytest.raises(DependencyMissing, match=r"pip install 'robolaser\[bbob\]'"):
        suite()["lee2004"].as_ioh()


def test_compare_knows_the_suite_by_name_and_each_lowest_cost_before_any_run():
    specs = specs_of(["suite"])
    assert [spec.name for spec in specs] == [f"suite:{name}" for name in IDS]
    first = specs[0].makers[0]()
    assert (first.summary.family, first.summary.lowest) == ("calibration", suite()[0].lowest)
    squares = (first.residuals(first.question.best_x[None]) ** 2).sum()
    assert squares == pytest.approx(first.summary.lowest, rel=1e-9)
