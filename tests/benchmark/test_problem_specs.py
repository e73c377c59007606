"""Problems are found by their names, and are what they say they are."""

import pickle
import subprocess
import sys

import cloudpickle
import numpy as np
import pytest
from pymoo.core.problem import ElementwiseProblem
from pymoo.problems import get_problem
from pymoo.problems.functional import FunctionalProblem

from robolaser.benchmark.problem import CALIBRATION, INFEASIBLE, OWN, TEST_FUNCTION
from robolaser.benchmark.problem_specs import spec_of, specs_of
from robolaser.benchmark.pymoo_specs import TEST_FUNCTIONS
from robolaser.benchmark.single_run import run
from robolaser.benchmark.solvers import find
from robolaser.data.writing import save
from robolaser.errors import BenchmarkError, UsageError
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

ASKED = ("paper", "reduced:paper", *(f"pymoo:{name}" for name in TEST_FUNCTIONS), "pymoo:rastrigin-3", "pymoo:g6")


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
    travelled = pickle.loads(cloudpickle.dumps(spec_of(text))).problem()
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
    for text in ("reduced:pymoo:sphere", "reduced:mine:Disc"):
        with pytest.raises(UsageError, match="Leave out `reduced:`"):
            spec_of(text)


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


class Disc(ElementwiseProblem):
    """A slope over a disc. Its lowest point lies on the rim."""

    def __init__(self, radius=1.0, n_obj=1, xl=-10.0):
        self.radius = radius
        super().__init__(n_var=2, n_obj=n_obj, n_ieq_constr=1, xl=xl, xu=10.0)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"], out["G"] = x.sum(), (x**2).sum() - self.radius**2


@pytest.mark.parametrize(
    "given",
    [Disc, Disc(), lambda: Disc(radius=1.0), f"{__name__}:Disc:radius=1", f"{__name__}:Disc"],
    ids=["class", "object", "factory", "path with settings", "path"],
)
def test_a_problem_of_ones_own_is_a_class_an_object_a_factory_or_an_import_path(given):
    spec = spec_of(given)
    problem = pickle.loads(cloudpickle.dumps(spec)).problem()
    assert problem.family == OWN
    assert (problem.dimension, problem.constraints, problem.lowest) == (2, 1, None)
    assert problem.cost(np.array([[0.5, 0.5], [3.0, 4.0]])).tolist() == [1.0, INFEASIBLE * 25.0]


def test_infeasible_candidates_cost_more_than_feasible_ones_and_more_the_more_they_violate():
    problem = spec_of("pymoo:g6").problem()
    x = problem.sample_uniform(np.random.default_rng(1), 20_000)
    cost = problem.cost(x)
    values = get_problem("g6").evaluate(x, return_values_of=["F", "G"])
    excess = np.maximum(values[1], 0.0).sum(axis=1)
    feasible = excess == 0.0
    assert 0 < feasible.sum() < len(x)
    assert cost[feasible].tolist() == values[0][feasible, 0].tolist()
    np.testing.assert_allclose(cost[~feasible] / INFEASIBLE - 1.0, excess[~feasible], rtol=1e-9, atol=1e-12)


def test_a_run_reports_its_lowest_cost_of_feasible_candidates_or_its_lowest_violation():
    problem = spec_of(Disc).problem()
    found = run(problem, find("de"), seed=1, budget=3000, time_limit_s=60.0)
    assert found.trace.final == pytest.approx(-np.sqrt(2), abs=0.02)
    assert found.violation == 0.0
    assert (found.trace.costs < INFEASIBLE).all()
    one = run(problem, find("random"), seed=1, budget=1, time_limit_s=60.0)
    assert one.trace.final == np.inf
    assert one.violation > 0.0


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ("pymoo:g1-5", "cannot be made"),
        ("pymoo:g1:colour=red", "cannot be made"),
        (lambda: Disc(xl=None), "a lower and an upper bound"),
        (f"{__name__}:Square", "has no 'Square'"),
        (f"{__name__}:np.pi", "expected a pymoo problem"),
        (f"{__name__}:Disc:colour=red", "has no setting 'colour'"),
        ("nowhere:Problem", "module nowhere cannot be imported"),
        (lambda: FunctionalProblem(2, lambda x: x.nothing, xl=0, xu=1), "fails at random candidates .AttributeError"),
    ],
)
def test_what_cannot_be_compared_on_is_refused_before_any_run(given, match):
    with pytest.raises(UsageError, match=match):
        spec_of(given)


def test_bbob_is_measured_above_its_lowest_value_which_ioh_knows():
    ioh = pytest.importorskip("ioh")
    problem = spec_of("bbob:15-5:instance=2").problem()
    theirs = ioh.get_problem(15, 2, 5, ioh.ProblemClass.BBOB)
    x = problem.sample_uniform(np.random.default_rng(1), 5)
    assert problem.cost(x).tolist() == [theirs(row) - theirs.optimum.y for row in x]
    assert problem.cost(np.array([theirs.optimum.x])) == pytest.approx(problem.lowest, abs=1e-9)
    with pytest.raises(UsageError, match="1 to 24"):
        spec_of("bbob:25")


LIGHT = """
import sys

class Absent:
    def find_spec(self, name, *args):
        if name.partition(".")[0] in {"pinocchio", "cv2", "numba", "serial", "yaml", "cyclopts", "cryptography"}:
            raise ModuleNotFoundError(name)

sys.meta_path.insert(0, Absent())

from pymoo.core.problem import Problem
from pymoo.problems.functional import FunctionalProblem
import robolaser.operators, robolaser.algorithms.rcga
from robolaser import RunPlan, compare
from robolaser.benchmark.problem_specs import spec_of
from robolaser.benchmark.single_run import run
from robolaser.benchmark.solvers import find
from robolaser.benchmark.standings import standings
for name in ("rcga", "ga", "cmaes", "scipy-de"):
    run(spec_of("pymoo:sphere").problem(), find(name), seed=1, budget=200, time_limit_s=60.0)

class Bowl(Problem):
    def __init__(self):
        super().__init__(n_var=3, n_obj=1, xl=-5, xu=5)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = (x**2).sum(axis=1)

result = compare(RunPlan.of(["pymoo:sphere", Bowl, "__main__:Bowl"], ["rcga"], seeds=1, budget=200))
assert len(result.runs) == 3 and not result.failures, result.failures
standings(result, "test function")
str(result), result.to_frame(), result.save(sys.argv[1])
"""


def test_comparing_on_test_functions_and_problems_of_a_script_needs_only_what_the_docs_name(tmp_path):
    subprocess.run([sys.executable, "-c", LIGHT, tmp_path], check=True)
    assert (tmp_path / "report.html").exists()
