"""Algorithms that begin with the best candidates of earlier runs."""

import numpy as np
import pytest

from robolaser import RunPlan
from robolaser.benchmark import load
from robolaser.benchmark.solvers import find
from robolaser.benchmark.table import starting_points
from robolaser.cli import main
from robolaser.errors import UsageError


@pytest.fixture(scope="module")
def earlier(tmp_path_factory):
    folder = tmp_path_factory.mktemp("earlier")
    typed = ["pymoo:rosenbrock-4", "pymoo:zdt1:n_var=5", "--algorithms", "pycma,NSGA2", "--seeds", "2"]
    assert main(["compare", *typed, "--budget", "2000", "--output", str(folder)]) == 0
    return folder


def alone(problem, name, starts=None):
    plan = RunPlan.of([problem], [name], seeds=1, budget=150, starts=starts)
    return plan.problems[0], plan.tasks[0].done(plan.problems[0])


def test_the_best_candidates_of_each_run_are_kept_with_what_they_cost(earlier):
    for run in load(earlier).runs:
        costs = RunPlan.of([run.problem], ["random"]).problems[0].cost(run.x)
        assert costs == pytest.approx(run.trace.final if run.front is None else run.front)


def test_the_lowest_cost_stands_first(earlier):
    problem = RunPlan.of(["pymoo:rosenbrock-4"], ["random"]).problems[0]
    costs = problem.cost(starting_points(earlier)["pymoo:rosenbrock-4"])
    assert costs[0] == costs.min()


@pytest.mark.parametrize(
    "name",
    ["rcga", "ga", "de", "pso", "cmaes", "nelder-mead", "es", "random", "scipy-de", "g3pcx", "isres", "ga:pop_size=3"],
)
def test_every_algorithm_begins_where_earlier_runs_ended(name, earlier):
    problem, run = alone("pymoo:rosenbrock-4", name, starting_points(earlier))
    assert not run.reason
    assert run.trace.final <= problem.cost(problem.starts[:1])[0] < alone("pymoo:rosenbrock-4", name)[1].trace.final


def test_fronts_are_begun_with_too(earlier):
    warm = alone("pymoo:zdt1:n_var=5", "NSGA2", starting_points(earlier))[1]
    assert warm.trace.final < 0.5 * alone("pymoo:zdt1:n_var=5", "NSGA2")[1].trace.final


def test_least_squares_descends_from_them_first():
    best = RunPlan.of(["reduced:paper"]).problems[0].sample_uniform(np.random.default_rng(1))
    plan = RunPlan.of(["reduced:paper"], ["least-squares", "screening"], starts={"reduced:paper": best})
    assert plan.refused["reduced:paper", "screening"] == "it begins with all parameters of a calibration"
    seen = []

    class Seen:
        problem = plan.problems[0]

        def residuals(self, x):
            seen.append(x)
            raise StopIteration

    with pytest.raises(StopIteration):
        find("least-squares").search(Seen(), 1)
    assert np.array_equal(seen[0], best)


def test_where_nothing_was_left_to_begin_with_it_is_said(earlier, tmp_path, capsys):
    with pytest.raises(UsageError, match="No earlier run on pymoo:sphere-4 with 4 variables"):
        RunPlan.of(["pymoo:sphere-4"], ["ga"], starts=starting_points(earlier))
    typed = ["compare", "pymoo:rosenbrock-4", "--algorithms", "ga", "--seeds", "1", "--budget", "100"]
    assert main([*typed, "--start-from", str(earlier), "--output", str(tmp_path / "warm")]) == 0
    assert main([*typed, "--output", str(tmp_path / "warm"), "--resume"]) == 1
    assert "not comparable" in capsys.readouterr().err
    assert main([*typed, "--start-from", str(tmp_path), "--output", str(tmp_path / "new")]) == 1
