"""Targets do not depend on where the cost's zero lies, and are printed as they are."""

import pytest

import robolaser
from robolaser.benchmark.standings.ranking import standings

ASKED = {"seeds": 2, "budget": 400}


def ranking(result):
    return [
        (place.algorithm, place.rank, place.success.value, place.running_time.value)
        for place in standings(result, result.families[0]).order.places
    ]


def test_a_constant_added_to_the_cost_changes_nothing():
    one, other = (
        robolaser.compare({"p": problem}, ["nelder-mead", "de"], **ASKED)
        for problem in ("mine:Sphere", "mine:Sphere:offset=-1000")
    )
    assert ranking(one) == ranking(other)
    assert ranking(one)[0][2] == 1.0


def test_the_text_states_the_target_that_was_used():
    result = robolaser.compare(
        {"p": "mine:Sphere:offset=-1000:lowest=-1000"}, ["random"], seeds=2, budget=50, target=0.5
    )
    said = " ".join(str(result).split())
    assert "a cost of at most -999.5, 0.5 above the lowest known, -1000 by theory" in said
    assert standings(result, "own problem").tolerance == 0.5
    assert result.to_dict()["problems"][0]["target"] == pytest.approx(-999.5)


def test_a_calibrations_target_is_a_share_of_the_lowest_cost():
    result = robolaser.compare(["paper"], ["screening"], seeds=1, budget=3000)
    (problem,) = result.problems
    assert problem.target(0.01) == pytest.approx(1.01 * problem.best)
    assert "an RMS within 0.5 % of the lowest known" in str(result)


def test_a_budget_may_be_for_each_variable():
    result = robolaser.compare(["pymoo:sphere-2", "pymoo:sphere-5"], ["random"], seeds=1, budget="100d")
    assert {run.problem: run.evaluations for run in result.runs} == {"pymoo:sphere-2": 200, "pymoo:sphere-5": 500}


def test_who_knows_the_budget_is_marked():
    result = robolaser.compare(
        ["pymoo:sphere-2"], ["rcga", "ga", "ga:mutation=NonUniformMutation"], seeds=1, budget=200
    )
    assert result.know_budget == {"rcga", "ga:mutation=NonUniformMutation"}
    assert str(result).count("knows its budget") == 2


def test_a_target_is_printed_with_as_many_digits_as_tell_it_from_the_lowest_cost():
    result = robolaser.compare({"p": "mine:Sphere:offset=-1000:lowest=-1000"}, ["random"], seeds=1, budget=50)
    assert "a cost of at most -999.99, 0.01 above" in " ".join(str(result).split())
