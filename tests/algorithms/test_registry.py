import numpy as np
import pytest
from pymoo.core.algorithm import Algorithm
from pymoo.operators.crossover.sbx import SBX
from pymoo.problems import get_problem

from robolaser import find_robot
from robolaser.algorithms.rcga import RCGA
from robolaser.algorithms.registry import ALGORITHMS, algorithm_named
from robolaser.algorithms.spec import AlgorithmSpec
from robolaser.calibration.initialization import find_start
from robolaser.calibration.plan import Plan
from robolaser.calibration.pymoo_search import search
from robolaser.errors import UsageError
from robolaser.model.forward_model import Model
from robolaser.operators import ArithmeticCrossover, ElitistReplacement, NonUniformMutation, RouletteSelection
from robolaser.simulation import paper


def history(text: str, seed: int = 1, generations: int = 5) -> np.ndarray:
    problem = get_problem("ackley", n_var=4)
    problem.names = tuple("abcd")
    _, course = search(problem, algorithm_named(text), generations=generations, seed=seed)
    return course.x


@pytest.mark.parametrize("text", ALGORITHMS)
def test_all_that_can_be_asked_for_search(text: str) -> None:
    assert isinstance(algorithm_named(text), Algorithm)
    assert history(text).shape[1] == 4


def settings_of(algorithm: RCGA) -> dict[str, object]:
    """The numbers that its parts work with."""
    crossover, mutation = algorithm.mating.crossover, algorithm.mating.mutation
    return {
        "pop_size": algorithm.pop_size, "n_elites": algorithm.survival.n_elites,
        "prob_crossover": crossover.prob.value, "prob_var": mutation.prob_var.value, "b": mutation.b.value,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("text", "settings"),
    [
        ("rcga:b=2", {"b": 2}),
        ("rcga:n_elites=0", {"n_elites": 0}),
        ("rcga:prob_var=0.3", {"prob_var": 0.3}),
        ("rcga:pop_size=50", {"pop_size": 50, "n_elites": 5}),
        ("rcga:prob_crossover=1", {"prob_crossover": 1}),
        (" rcga : b = 2 : prob_var = 0.2 ", {"b": 2, "prob_var": 0.2}),
    ],
)
def test_a_setting_changes_what_it_names_and_nothing_else(text: str, settings: dict[str, object]) -> None:
    assert settings_of(algorithm_named(text)) == settings_of(RCGA()) | settings


@pytest.mark.parametrize(
    ("text", "place", "kind"),
    [
        ("ga:crossover=ArithmeticCrossover", "crossover", ArithmeticCrossover),
        ("ga:mutation=NonUniformMutation", "mutation", NonUniformMutation),
        ("ga:selection=RouletteSelection", "selection", RouletteSelection),
        ("ga:survival=ElitistReplacement", "survival", ElitistReplacement),
    ],
)
def test_one_operator_is_swapped_and_the_others_stay(text: str, place: str, kind: type) -> None:
    ours, theirs = algorithm_named(text), algorithm_named("ga")
    for part in ("crossover", "mutation", "selection", "survival"):
        one, other = (getattr(a if part == "survival" else a.mating, part) for a in (ours, theirs))
        assert type(one) is (kind if part == place else type(other))


def test_with_all_four_swapped_pymoos_algorithm_is_the_papers() -> None:
    swapped = (
        "ga:crossover=ArithmeticCrossover:mutation=NonUniformMutation:selection=RouletteSelection"
        ":survival=ElitistReplacement:survival.n_elites=10"
    )
    assert np.array_equal(history(f"{swapped}:eliminate_duplicates=false"), history("rcga"))


def test_an_operator_takes_settings_after_its_place() -> None:
    made = algorithm_named(
        "ga:mutation=NonUniformMutation:mutation.b=2:mutation.prob_var=0.3:crossover=SBX:crossover.eta=3"
    )
    assert (made.mating.mutation.b.value, made.mating.mutation.prob_var.value) == (2, 0.3)
    assert type(made.mating.crossover) is SBX
    assert made.mating.crossover.eta.value == 3


@pytest.mark.parametrize("text", ["ga:mutation=GaussianMutation", "ga:crossover=DEX", "pattern-search"])
def test_a_calibrations_search_is_its_seed_also_where_pymoo_forgets_it(text: str) -> None:
    model = Model(paper(find_robot("scorbot_er7"), seed=1).dataset)
    plan = Plan(algorithm=text, polish=False, generations=5)
    first, again = (find_start(model, plan) for _ in range(2))
    assert np.array_equal(first.history.x, again.history.x)


def test_values_are_read_as_what_they_look_like() -> None:
    spec = AlgorithmSpec.of("name:a=1:b=1e3:c=true:d=False:e=none:f=best1bin:g=-2:h=0.5")
    assert dict(spec.settings) == {
        "a": 1, "b": 1e3, "c": True, "d": False, "e": None, "f": "best1bin", "g": -2, "h": 0.5
    }  # fmt: skip
    assert [type(value) for value in spec.settings.values()][:3] == [int, float, bool]


def test_any_algorithm_of_pymoo_is_there_by_its_import_path() -> None:
    made = algorithm_named("pymoo.algorithms.soo.nonconvex.nrbo:NRBO:pop_size=30")
    assert (type(made).__name__, made.pop_size) == ("NRBO", 30)


@pytest.mark.parametrize(
    ("text", "error", "said"),
    [
        ("rgca", UsageError, "Did you mean 'rcga'?"),
        ("rcga:elites=3", UsageError, "Did you mean 'n_elites'?"),
        ("rcga:prob_var=2", UsageError, "a number from 0 to 1"),
        ("screening:b=2", UsageError, "No algorithm 'screening'"),
        ("pso:crossover=ArithmeticCrossover", UsageError, "pso has no"),
    ],
)
def test_what_makes_no_sense_is_said(text: str, error: type[Exception], said: str) -> None:
    with pytest.raises(error) as caught:
        algorithm_named(text)
    assert said in str(caught.value)
