"""Problems are found by their names, and are what they say they are."""

import pickle

import numpy as np
import pytest

from robolaser.benchmark.problem import CALIBRATION, TEST_FUNCTION
from robolaser.benchmark.problem_specs import TEST_FUNCTIONS, spec_of, specs_of
from robolaser.data.writing import save
from robolaser.errors import BenchmarkError, UsageError
from robolaser.geometry.robots import find_robot
from robolaser.simulation import simulate

ASKED = ("paper", "reduced:paper", *(f"pymoo:{name}" for name in TEST_FUNCTIONS), "pymoo:rastrigin-3")


@pytest.fixture(scope="module")
def problem():
    return {text: spec_of(text).problem() for text in ASKED}


@pytest.fixture(scope="module")
def tracker(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data") / "tracked"
    save(simulate(find_robot("ur5"), kind="point", poses=10, seed=1, name="tracked").dataset, folder)
    return folder


@pytest.mark.parametrize("text", ASKED)
def test_a_problem_gives_each_candidate_its_own_cost(text, problem):
    asked = problem[text]
    x = asked.sample_uniform(np.random.default_rng(1), 20)
    assert x.shape == (20, asked.dimension)
    together = asked.cost(x)
    alone = np.concatenate([asked.cost(one[None]) for one in x])
    np.testing.assert_allclose(together, alone, rtol=1e-9)


@pytest.mark.parametrize("text", ASKED)
def test_a_pickled_spec_builds_the_same_problem(text, problem):
    x = problem[text].sample_uniform(np.random.default_rng(1), 20)
    travelled = pickle.loads(pickle.dumps(spec_of(text))).problem()
    assert travelled.cost(x).tolist() == problem[text].cost(x).tolist()
    assert (travelled.name, travelled.variables) == (problem[text].name, problem[text].variables)


@pytest.mark.parametrize("text", ["paper", "reduced:paper"])
def test_squares_of_residuals_add_up_to_the_cost(text, problem):
    asked = problem[text]
    x = asked.sample_uniform(np.random.default_rng(1), 20)
    np.testing.assert_allclose((asked.residuals(x) ** 2).sum(axis=1), asked.cost(x), rtol=1e-9)


def test_the_papers_problem_has_fourteen_variables_and_its_reduction_six(problem):
    assert problem["paper"].dimension == 14
    assert problem["reduced:paper"].dimension == 6
    assert problem["paper"].family == problem["reduced:paper"].family == CALIBRATION


@pytest.mark.parametrize("name", TEST_FUNCTIONS)
def test_no_candidate_costs_less_than_theory_says(name, problem):
    asked = problem[f"pymoo:{name}"]
    assert asked.family == TEST_FUNCTION
    assert (asked.cost(asked.sample_uniform(np.random.default_rng(1), 1000)) >= asked.lowest).all()


def test_a_test_function_has_the_variables_asked_for(problem):
    assert problem["pymoo:rastrigin-3"].dimension == 3


def test_the_reduction_is_lower_wherever_it_has_the_same_candidate(problem):
    whole, reduced = problem["paper"], problem["reduced:paper"]
    x = whole.sample_uniform(np.random.default_rng(1), 50)
    x[:, whole.variables.index("f")] = whole.model.parameters.nominal[whole.variables.index("f")]
    kept = [whole.variables.index(name) for name in reduced.variables]
    assert np.mean(reduced.cost(x[:, kept]) <= whole.cost(x) * (1 + 1e-9)) > 0.95


def test_a_folder_is_asked_for_by_its_path_and_known_by_its_name(tracker):
    asked = spec_of(str(tracker)).problem()
    assert asked.name == "tracked"
    assert np.isfinite(asked.cost(asked.sample_uniform(np.random.default_rng(1), 5))).all()


def test_what_follows_in_closed_form_altogether_leaves_nothing_to_compare_on(tracker):
    with pytest.raises(BenchmarkError, match="nothing is left to search for"):
        spec_of(f"reduced:{tracker}")


def test_an_unknown_problem_is_answered_by_what_there_is():
    with pytest.raises(UsageError, match="No folder 'scorbot-floor'"):
        spec_of("scorbot-floor")


@pytest.mark.parametrize("text", ["pymoo:ackley-1", "pymoo:ackley-many", "pymoo:ackley-"])
def test_a_senseless_number_of_variables_is_answered_by_what_was_expected(text):
    with pytest.raises(UsageError, match="a whole number of at least 2"):
        spec_of(text)


def test_a_test_function_has_no_reduction():
    with pytest.raises(UsageError, match="Leave out `reduced:`"):
        spec_of("reduced:pymoo:sphere")


def test_a_problem_that_is_named_twice_counts_once():
    assert len(specs_of(["pymoo:sphere", "pymoo:sphere"])) == 1


@pytest.mark.parametrize("text", ["pymoo:rastrigen", "pymoo:"])
def test_an_unknown_test_function_is_answered_by_those_there_are(text):
    with pytest.raises(UsageError, match="pymoo:ackley"):
        spec_of(text)


def test_two_problems_of_one_name_are_refused(tracker):
    with pytest.raises(UsageError, match="both called 'tracked'"):
        specs_of([str(tracker), "paper", str(tracker) + "/"])


@pytest.mark.parametrize("text", ["paper", "pymoo:ackley"])
def test_nobody_can_move_the_bounds(text, problem):
    with pytest.raises(ValueError, match="read-only"):
        problem[text].lower[0] = -1.0
