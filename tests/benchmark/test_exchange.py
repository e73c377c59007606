"""One part of an algorithm is exchanged, and what that does is measured against all that is else alike."""

import json
from functools import partial
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
from made_up import made_up_comparison
from mine import halving
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.problem import Problem
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.repair.rounding import RoundingRepair

from robolaser.algorithms.registry import algorithm_named
from robolaser.benchmark.evaluator import RunLimits
from robolaser.benchmark.named_problems import specs_of
from robolaser.benchmark.run import Task, run
from robolaser.benchmark.solvers import find
from robolaser.benchmark.standings.ranking import standings
from robolaser.cli import main
from robolaser.errors import UsageError
from robolaser.operators import ArithmeticCrossover

MINE = ArithmeticCrossover(prob=0.5)


def effects(result):
    return standings(result, "calibration").effects


@pytest.mark.parametrize(
    ("operator", "kind"),
    [
        ("SBX:crossover.eta=3", SBX),
        ("ArithmeticCrossover", ArithmeticCrossover),
        (f"{__name__}:MINE", ArithmeticCrossover),
    ],
)
def test_an_operator_is_found_by_any_of_its_names(operator, kind):
    algorithm = algorithm_named(f"GA:pop_size=30:crossover={operator}")
    assert isinstance(algorithm, GA)
    assert isinstance(algorithm.mating.crossover, kind)
    assert algorithm.pop_size == 30


def test_an_operator_has_operators_of_its_own():
    algorithm = algorithm_named("GA:crossover=SBX:crossover.repair=RoundingRepair")
    assert isinstance(algorithm.mating.crossover.repair, RoundingRepair)


@pytest.mark.parametrize(
    "slot",
    ["sampling=LHS", "selection=RouletteSelection", "crossover=SBX", "mutation=PM", "survival=ElitistReplacement"],
)
@pytest.mark.parametrize("stock", ["ga", "GA", "rcga", "SMSEMOA"])
def test_every_slot_of_a_genetic_algorithm_can_be_exchanged(stock, slot):
    find(f"{stock}:{slot}")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("GA:crossover=SBY", "No crossover 'SBY'"),
        ("GA:crossover=SBX:crossover.colour=1", "no setting 'colour'"),
        ("GA:crossover=SBX:crossover=UX", "given twice"),
        ("GB:crossover=SBX", "No algorithm 'GB'"),
        ("random:crossover=SBX", "cannot be exchanged"),
        (f"GA:crossover={__name__}:MINE:crossover.prob=0.9", "an instance has its settings already"),
        ("ga:bb=2:crossover=SBX", "bb"),
        ("cmaes:crossover=SBX", "cmaes has no (place for another |setting ')crossover"),
        ("NSGA2:survival=ElitistReplacement", "ElitistReplacement cannot serve NSGA2"),
    ],
)
def test_what_cannot_be_exchanged_is_said(text, said):
    with pytest.raises(UsageError, match=said):
        find(text)


@pytest.mark.parametrize(
    ("make", "text", "said"),
    [
        (find, "mine:halving:crossover=SBX", "no setting 'crossover'"),
        (specs_of, ["pymoo:sphere-2:crossover=SBX"], "pymoo:sphere has no setting 'crossover'"),
        (specs_of, ["pymoo:bnh:n_var=5"], "pymoo:bnh has no setting 'n_var'"),
        (specs_of, ["pymoo:sphere-5:n_var=6"], "5 and 6 variables. State one number"),
        (specs_of, ["pymoo:sphere:n_var=2.5"], "n_var is 2.5, expected a whole number"),
        (specs_of, ["mine:Sphere:crossover=SBX"], "no setting 'crossover'"),
        (specs_of, ["mine:SPHERE:offset=1"], "an instance has its settings already"),
    ],
)
def test_no_setting_is_ignored_by_what_has_no_operators(make, text, said):
    with pytest.raises(UsageError, match=said):
        make(text)


@pytest.mark.parametrize("upper", [None, np.inf, [1.0, np.nan]])
def test_a_problem_without_finite_bounds_is_refused(upper):
    with pytest.raises(UsageError, match="needs a finite lower and upper bound"):
        specs_of({"p": Problem(n_var=2, n_obj=1, xl=0.0, xu=upper)})


def test_a_problem_may_have_a_setting_with_the_name_of_an_operator():
    (spec,) = specs_of(["mine:Sampled:sampling=4"])
    assert spec.made_for(1).dimension == 4


def test_an_exchanged_algorithm_runs_and_repeats_itself():
    sphere, text = (
        specs_of(["pymoo:sphere-3"])[0].makers[0](),
        "GA:crossover=ArithmeticCrossover:mutation=NonUniformMutation",
    )
    task = Task("p", text, 1, RunLimits(500, 60.0), b"", b"", "")
    one, again = (run(sphere, find(text), task) for _ in range(2))
    assert one.evaluations == 500
    assert one.trace.costs.tolist() == again.trace.costs.tolist()
    assert find(text).title == "pymoo's GA with ArithmeticCrossover as crossover and NonUniformMutation as mutation"


def test_a_partial_function_has_the_title_of_its_function():
    assert find(partial(halving), "mine").title == "Random steps from the best point, halved after each failure"


def test_the_effect_of_a_part_is_that_among_runs_alike_in_all_else():
    speeds = {"GA": 1.0, "GA:crossover=X": 3.0, "GA:mutation=M": 1.0, "GA:crossover=X:mutation=M": 3.0, "other": 9.0}
    x, m = effects(made_up_comparison(speeds, seeds=12))
    assert [(one.stock, one.slot, one.operator, one.strata) for one in (x, m)] == [
        ("GA", "crossover", "X", 4),
        ("GA", "mutation", "M", 4),
    ]
    assert x.superiority.lower > 0.9
    assert x.ratio.upper < 1.0
    assert x.ratio.value == pytest.approx(1 / 3, rel=0.25)
    assert x.p_adjusted < 1e-6
    assert m.superiority.lower < 0.5 < m.superiority.upper
    assert m.p_adjusted >= m.p > 0.05
    assert effects(made_up_comparison({"GA": 1.0, "de": 2.0})) == ()


def test_a_part_without_effect_is_hardly_ever_called_one():
    speeds = {"GA": 1.0, "GA:crossover=X": 1.0}
    results = [made_up_comparison(speeds, seeds=6, problems=(f"p{i}", f"q{i}")) for i in range(40)]
    assert np.mean(np.array([effects(result)[0].p for result in results]) < 0.05) <= 0.15


def test_the_effect_of_each_exchanged_part_is_shown(tmp_path, capsys):
    stock = "GA:pop_size=20"
    typed = f"{stock},{stock}:crossover=ArithmeticCrossover,{stock}:crossover=SBX"
    asked = ["compare", "pymoo:sphere-2", "--algorithms", typed, "--seeds", "2", "--budget", "200"]
    assert main([*asked, "--output", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "What each exchanged operator does" in shown
    assert "ArithmeticCrossover as crossover" in shown
    said = json.loads((tmp_path / "comparison.json").read_text())
    jsonschema.validate(said, json.loads(files("robolaser").joinpath("schemas/comparison.schema.json").read_text()))
    assert [one["operator"] for one in said["standings"][0]["effects"]] == ["ArithmeticCrossover", "SBX"]
    assert "What each exchanged operator does" in (tmp_path / "report.html").read_text()
