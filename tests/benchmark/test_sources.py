"""Problems are found by what is typed, and ask what they say they ask."""

import pickle

import numpy as np
import pytest

from robolaser.benchmark.problem import CALIBRATION, TEST_FUNCTION
from robolaser.benchmark.problem_specs import TEST_FUNCTIONS, source, sources
from robolaser.data.writing import save
from robolaser.errors import (
    DimensionSenseless,
    NoClosedForm,
    NothingToSearch,
    ProblemTwice,
    ProblemUnknown,
    TestFunctionUnknown,
)
from robolaser.geometry.robots import find_robot
from robolaser.simulation import simulate

ASKED = ("paper", "reduced:paper", *(f"pymoo:{name}" for name in TEST_FUNCTIONS), "pymoo:rastrigin-3")


@pytest.fixture(scope="module")
def question():
    return {text: source(text).question() for text in ASKED}


@pytest.fixture(scope="module")
def tracker(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data") / "tracked"
    save(simulate(find_robot("ur5"), kind="point", poses=10, seed=1, name="tracked").dataset, folder)
    return folder


@pytest.mark.parametrize("text", ASKED)
def test_a_question_gives_each_candidate_its_own_cost(text, question):
    asked = question[text]
    x = asked.anywhere(np.random.default_rng(1), 20)
    assert x.shape == (20, asked.dimension)
    together = asked.cost(x)
    alone = np.concatenate([asked.cost(one[None]) for one in x])
    np.testing.assert_allclose(together, alone, rtol=1e-9)


@pytest.mark.parametrize("text", ASKED)
def test_a_source_asks_the_same_after_a_journey(text, question):
    x = question[text].anywhere(np.random.default_rng(1), 20)
    travelled = pickle.loads(pickle.dumps(source(text))).question()
    assert travelled.cost(x).tolist() == question[text].cost(x).tolist()
    assert (travelled.name, travelled.variables) == (question[text].name, question[text].variables)


@pytest.mark.parametrize("text", ["paper", "reduced:paper"])
def test_squares_of_residuals_add_up_to_the_cost(text, question):
    asked = question[text]
    x = asked.anywhere(np.random.default_rng(1), 20)
    np.testing.assert_allclose((asked.residuals(x) ** 2).sum(axis=1), asked.cost(x), rtol=1e-9)


def test_the_papers_problem_has_fourteen_variables_and_its_reduction_six(question):
    assert question["paper"].dimension == 14
    assert question["reduced:paper"].dimension == 6
    assert question["paper"].family == question["reduced:paper"].family == CALIBRATION


@pytest.mark.parametrize("name", TEST_FUNCTIONS)
def test_no_candidate_costs_less_than_theory_says(name, question):
    asked = question[f"pymoo:{name}"]
    assert asked.family == TEST_FUNCTION
    assert (asked.cost(asked.anywhere(np.random.default_rng(1), 1000)) >= asked.lowest).all()


def test_a_test_function_has_the_variables_asked_for(question):
    assert question["pymoo:rastrigin-3"].dimension == 3


def test_the_reduction_is_lower_wherever_it_has_the_same_candidate(question):
    whole, reduced = question["paper"], question["reduced:paper"]
    x = whole.anywhere(np.random.default_rng(1), 50)
    x[:, whole.variables.index("f")] = whole.model.parameters.nominal[whole.variables.index("f")]
    kept = [whole.variables.index(name) for name in reduced.variables]
    assert np.mean(reduced.cost(x[:, kept]) <= whole.cost(x) * (1 + 1e-9)) > 0.95


def test_a_folder_is_asked_for_by_its_path_and_known_by_its_name(tracker):
    asked = source(str(tracker)).question()
    assert asked.name == "tracked"
    assert np.isfinite(asked.cost(asked.anywhere(np.random.default_rng(1), 5))).all()


def test_what_follows_in_closed_form_altogether_leaves_nothing_to_compare_on(tracker):
    with pytest.raises(NothingToSearch, match="nothing is left to be searched"):
        source(f"reduced:{tracker}")


def test_a_problem_that_is_nowhere_is_told_what_there_is():
    with pytest.raises(ProblemUnknown, match="No folder 'scorbot-floor'"):
        source("scorbot-floor")


@pytest.mark.parametrize("text", ["pymoo:ackley-1", "pymoo:ackley-many", "pymoo:ackley-"])
def test_a_senseless_number_of_variables_is_told_what_was_expected(text):
    with pytest.raises(DimensionSenseless, match="a whole number from 2"):
        source(text)


def test_a_test_function_has_no_reduction():
    with pytest.raises(NoClosedForm, match="Leave out `reduced:`"):
        source("reduced:pymoo:sphere")


def test_a_problem_that_is_named_twice_is_asked_once():
    assert len(sources(["pymoo:sphere", "pymoo:sphere"])) == 1


@pytest.mark.parametrize("text", ["pymoo:rastrigen", "pymoo:"])
def test_an_unknown_test_function_is_told_which_are_near(text):
    with pytest.raises(TestFunctionUnknown, match="pymoo:ackley"):
        source(text)


def test_two_problems_of_one_name_are_refused(tracker):
    with pytest.raises(ProblemTwice, match="both called 'tracked'"):
        sources([str(tracker), "paper", str(tracker) + "/"])


@pytest.mark.parametrize("text", ["paper", "pymoo:ackley"])
def test_nobody_can_move_the_bounds(text, question):
    with pytest.raises(ValueError, match="read-only"):
        question[text].lower[0] = -1.0
