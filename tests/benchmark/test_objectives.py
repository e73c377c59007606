"""Problems with several objectives are compared by hypervolume, IGD+ and attainment."""

import json
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
from pymoo.indicators.hv import HV
from pymoo.indicators.igd_plus import IGDPlus
from pymoo.problems import get_problem
from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting

from robolaser.benchmark import load
from robolaser.benchmark.engines import ThisMachine
from robolaser.benchmark.front import REFERENCE, Front
from robolaser.benchmark.objectives import attainment, igd_plus
from robolaser.benchmark.plan import RunPlan
from robolaser.benchmark.problem_specs import spec_of
from robolaser.benchmark.run_loop import fill
from robolaser.benchmark.single_run import run
from robolaser.benchmark.solvers import find
from robolaser.benchmark.standings import standings
from robolaser.benchmark.table import NAME, RunTable
from robolaser.report.comparison import page


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("several")
    plan = RunPlan.of(["pymoo:zdt1:n_var=5", "pymoo:bnh"], ["NSGA2:pop_size=20", "random", "ga"], seeds=3, budget=600)
    with ThisMachine(2) as engine, RunTable(folder / NAME) as table:
        fill(table, plan, engine)
        made = table.result(plan)
    assert [run.front.tolist() for run in load(folder).runs] == [run.front.tolist() for run in made.runs]
    return made


def test_a_front_holds_what_nothing_dominates_and_misses_the_rest_of_the_hypervolume():
    rng = np.random.default_rng(1)
    for m in (2, 3):
        values = rng.random((200, m))
        front = Front.empty(2, np.zeros(m), np.ones(m))
        for part in np.split(values, 4):
            front = front.extended(part, part[:, :2])
        kept = values[NonDominatedSorting().do(values, only_non_dominated_front=True)]
        assert sorted(front.points.tolist()) == sorted(kept.tolist())
        expected = REFERENCE**m - HV(ref_point=np.full(m, REFERENCE))(values)
        assert front.missing == pytest.approx(expected, rel=1e-12)


def test_the_known_front_itself_misses_nothing():
    problem, front = get_problem("zdt1", n_var=5), spec_of("pymoo:zdt1:n_var=5").problem().front
    known = problem.pareto_front()
    assert front.extended(known, np.zeros((len(known), 5))).missing == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("name", ["zdt1:n_var=5", "bnh", "dtlz2:n_var=5:n_obj=3"])
def test_the_cost_of_a_run_is_the_hypervolume_that_the_front_of_all_feasible_candidates_misses(name):
    problem = spec_of(f"pymoo:{name}").problem()
    seen = []

    def searched(x):
        seen.append(np.atleast_2d(asked(x)))
        return seen[-1]

    asked = problem.cost
    object.__setattr__(problem, "cost", searched)
    made = run(problem, find("random"), seed=1, budget=250, time_limit_s=60.0)
    everything = np.concatenate(seen)[:250]
    feasible = everything[(everything < 1e29).all(axis=1)]
    assert made.trace.final == pytest.approx(
        problem.front.extended(feasible, np.zeros((len(feasible), problem.dimension))).missing
    )
    assert (np.diff(made.trace.costs) < 0).all()
    assert made.trace.evaluations[-1] <= made.evaluations == 250


def test_algorithms_of_several_objectives_are_ranked_and_those_of_one_refuse(result):
    assert not result.failures
    assert {name for _, name in result.refused} == {"ga"}
    assert "one objective" in next(iter(result.refused.values()))
    ranked = standings(result, "test function")
    assert ranked.by_problem[0].evaluations.places[0].algorithm == "NSGA2:pop_size=20"


def test_the_result_keeps_its_schema(result):
    schema = json.loads(files("robolaser").joinpath("schemas/comparison.schema.json").read_text())
    jsonschema.validate(result.to_dict(), schema)


def test_igd_plus_is_pymoos_from_what_all_runs_found_together(result):
    frame = igd_plus(result)
    assert len(frame) == len(result.runs) == 12
    for name in ("pymoo:zdt1:n_var=5", "pymoo:bnh"):
        fronts = {run.key: run.front for run in result.runs if run.problem == name}
        together = np.concatenate(list(fronts.values()))
        best = np.unique(together[NonDominatedSorting().do(together, only_non_dominated_front=True)], axis=0)
        for row in frame[frame.problem == name].itertuples():
            front = fronts[row.problem, row.algorithm, row.seed]
            assert row.igd_plus == pytest.approx(IGDPlus(best / np.ptp(best, axis=0))(front / np.ptp(best, axis=0)))
    best_of = frame.groupby("algorithm").igd_plus.median()
    assert best_of["NSGA2:pop_size=20"] < best_of["random"]


def test_attainment_surfaces_are_what_so_many_runs_attained(result):
    name, algorithm = "pymoo:zdt1:n_var=5", "random"
    fronts = [run.front for run in result.runs if run.key[:2] == (name, algorithm)]
    for *corner, share in attainment(result, name, algorithm, (1 / 3, 1.0)):
        attained = np.mean([(front <= np.array(corner) + 1e-12).all(axis=1).any() for front in fronts])
        assert attained >= share - 1e-9


def test_the_page_shows_igd_plus_and_what_half_of_the_runs_attain(result):
    text = page(result, [standings(result, family) for family in result.families])
    assert "IGD+ of the fronts" in text
    assert "Half of the runs attain this on pymoo:zdt1:n_var=5 (problem 1)" in text


def test_asking_for_the_cost_of_several_objectives_is_answered_by_what_to_ask_for():
    def asks_for_cost(evaluator, seed):
        evaluator.cost(evaluator.problem.sample_uniform(np.random.default_rng(seed), 10))

    solver = find("random")
    solver.search = asks_for_cost
    failed = run(spec_of("pymoo:zdt1").problem(), solver, seed=1, budget=50, time_limit_s=10.0)
    assert "has 2 objectives: evaluate them with `objectives(x)`" in failed.reason
