import random
import sys
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pymoo.util
import pytest
import scipy.optimize

from robolaser import find_robot
from robolaser.benchmark.evaluator import BudgetedEvaluator, BudgetExhausted
from robolaser.benchmark.problem import CALIBRATION, TEST_FUNCTION, BenchmarkProblem
from robolaser.benchmark.single_run import DONE, FAILED, BenchmarkRun, run
from robolaser.benchmark.solvers import DEFAULT, SOLVERS, find
from robolaser.errors import UsageError
from robolaser.estimation.multistart import multistart
from robolaser.model.forward_model import Model
from robolaser.simulation import paper

BUDGET = 2000
SEARCHING = [name for name in SOLVERS if name != "screening"]
SWAPPED = [
    "ga:crossover=arithmetic",
    "ga:crossover=de",
    "ga:crossover=pcx",
    "ga:mutation=non-uniform",
    "ga:mutation=gaussian",
    "ga:selection=roulette",
    "ga:selection=random",
    "ga:survival=elitist",
    "rcga:form=power:pop_size=50:n_elites=0",
    "cmaes:bipop=true:restarts=4",
    "least-squares:method=dogbox",
    "pymoo.algorithms.soo.nonconvex.ga:GA:pop_size=30",
]


class Sphere:
    """A bowl off the middle of a box of very unequal sides; notes whatever it is asked."""

    def __init__(self, d: int = 5, *, pole: bool = False) -> None:
        self.lower = -np.logspace(-4, 3, d)
        self.upper = 3.0 * np.logspace(-4, 3, d)
        self.pole = pole
        self.asked: list[np.ndarray] = []

    def residuals(self, x: np.ndarray) -> np.ndarray:
        self.asked.append(x.copy())
        y = (x - self.lower) / (self.upper - self.lower)
        return np.where(self.pole & (y[:, :1] > 0.7), np.nan, 1e-2 * (y - np.linspace(0.2, 0.6, len(self.lower))))

    def cost(self, x: np.ndarray) -> np.ndarray:
        return (self.residuals(x) ** 2).sum(axis=1)

    def problem(self) -> BenchmarkProblem:
        return BenchmarkProblem(
            "sphere",
            "a bowl",
            TEST_FUNCTION,
            tuple(f"x{i}" for i in range(len(self.lower))),
            self.lower,
            self.upper,
            cost=self.cost,
            unit="m²",
            scale=1.0,
            residuals=self.residuals,
            lowest=0.0,
        )


def ran(text: str, problem: BenchmarkProblem, *, seed: int = 1, budget: int = BUDGET) -> BenchmarkRun:
    return run(problem, find(text), seed=seed, budget=budget, time_limit_s=60.0)


def calibration() -> BenchmarkProblem:
    model = Model(paper(find_robot("scorbot_er7"), seed=1).dataset)
    p = model.parameters
    return BenchmarkProblem(
        "paper",
        "",
        CALIBRATION,
        p.names,
        p.lower,
        p.upper,
        cost=model.cost,
        unit="m²",
        scale=1e-10,
        residuals=lambda x: model.residuals(x).reshape(len(x), -1),
        model=model,
    )


@pytest.mark.parametrize("text", [*SEARCHING, *SWAPPED])
def test_a_bowl_is_searched_to_the_end_of_the_budget(text: str) -> None:
    bowl = Sphere()
    made = ran(text, bowl.problem())
    start = bowl.cost(bowl.problem().sample_uniform(np.random.default_rng(1), 100)).min()
    assert (made.state, made.reason, made.evaluations) == (DONE, "", BUDGET)
    assert made.trace.evaluations[-1] <= BUDGET
    assert made.trace.final <= (start / 5 if text != "random" else start)
    assert made.algorithm == text


def asked_by(text: str, *, seed: int, budget: int = 250) -> np.ndarray:
    """All candidates that it asks for, in order, (n, d)."""
    bowl = Sphere()
    with np.errstate(all="ignore"), pytest.raises(BudgetExhausted):
        find(text).search(BudgetedEvaluator(bowl.problem(), budget=budget, time_limit_s=60.0), seed)
    return np.vstack(bowl.asked)


@pytest.mark.parametrize("text", [*SEARCHING, *SWAPPED])
def test_the_same_seed_asks_for_the_same_candidates_and_another_for_others(text: str) -> None:
    first = asked_by(text, seed=2)
    np.random.random(7)  # noqa: NPY002
    assert np.array_equal(first, asked_by(text, seed=2))
    assert not np.array_equal(first[:20], asked_by(text, seed=3)[:20])


@pytest.mark.parametrize("text", SEARCHING)
def test_a_search_leaves_everything_global_as_it_was(text: str) -> None:
    before = _global()
    asked_by(text, seed=2, budget=150)
    assert _global() == before


def _global() -> tuple[object, ...]:
    name, keys, *rest = np.random.get_state()  # noqa: NPY002
    return random.getstate(), name, keys.tobytes(), rest, tuple(warnings.filters), pymoo.util.np, np.geterr()


@pytest.mark.parametrize("text", [*SEARCHING, *SWAPPED])
def test_nobody_asks_outside_the_bounds_even_beside_a_pole(text: str) -> None:
    bowl = Sphere(3, pole=True)
    made = ran(text, bowl.problem(), budget=1000)
    assert (made.state, made.reason) == (DONE, "")
    x = np.vstack(bowl.asked)
    assert (x >= bowl.lower).all()
    assert (x <= bowl.upper).all()


@pytest.mark.parametrize("text", DEFAULT)
def test_a_calibration_can_be_asked_of_everybody(text: str, paper_problem: BenchmarkProblem) -> None:
    made = ran(text, paper_problem, budget=15_000 if text == "screening" else 500)
    assert find(text).refuses(paper_problem) is None
    assert (made.state, made.reason) == (DONE, "")
    assert np.isfinite(made.trace.final)


@pytest.fixture(scope="module")
def paper_problem() -> BenchmarkProblem:
    return calibration()


@pytest.mark.parametrize("text", ["nelder-mead", "pattern-search"])
def test_a_search_that_has_collapsed_begins_anew_elsewhere(text: str) -> None:
    y = asked_by(text, seed=1, budget=2500)
    bowl = Sphere()
    far = np.abs((y - bowl.lower) / (bowl.upper - bowl.lower) - np.linspace(0.2, 0.6, 5)).max(axis=1) > 0.3
    assert far[:20].any()
    assert far[1000:].any()


def test_least_squares_asks_what_scipys_own_differences_would_ask(paper_problem: BenchmarkProblem) -> None:
    asked: list[np.ndarray] = []

    def residuals(x: np.ndarray) -> np.ndarray:
        asked.append(np.array(x, ndmin=2))
        return paper_problem.residuals(asked[-1]).reshape(len(asked[-1]), -1)

    lower, upper = paper_problem.lower, paper_problem.upper
    scipy.optimize.least_squares(
        lambda x: residuals(x)[0],
        paper_problem.sample_uniform(np.random.default_rng(3))[0],
        bounds=(lower, upper),
        x_scale=upper - lower,
        ftol=1e-12,
        xtol=1e-12,
        gtol=1e-12,
    )
    theirs = np.vstack(asked)
    asked.clear()
    ran("least-squares", replace(paper_problem, residuals=residuals), seed=3, budget=len(theirs))
    assert np.array_equal(np.vstack(asked)[: len(theirs)], theirs)


def test_screening_is_counted_with_the_cost_of_all_rows(paper_problem: BenchmarkProblem) -> None:
    made = ran("screening", paper_problem, budget=50_000)
    assert made.state == DONE
    assert len(made.trace.costs) >= 1
    assert made.evaluations < 50_000
    assert made.trace.final == pytest.approx(multistart(paper_problem.model, seed=1).cost, rel=1e-9)


def test_a_solver_that_does_not_apply_says_why(paper_problem: BenchmarkProblem) -> None:
    bowl = Sphere().problem()
    plain = replace(bowl, residuals=None)
    assert [name for name in DEFAULT if find(name).refuses(paper_problem)] == []
    assert [name for name in DEFAULT if find(name).refuses(bowl)] == ["screening"]
    assert [name for name in DEFAULT if find(name).refuses(plain)] == ["screening", "least-squares"]


def test_all_by_name_have_a_title_and_their_name() -> None:
    assert all(find(name).name == name and find(name).title == SOLVERS[name] for name in DEFAULT)


OWN = '''"""What a user may write."""
import numpy as np
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.algorithm import Algorithm
from robolaser.benchmark.solvers.solver import Solver


class Mine(GA):
    """A genetic algorithm of mine.

    It is small.
    """

    def __init__(self, pop_size=20, **kwargs):
        super().__init__(pop_size=pop_size, **kwargs)


instance = Mine(pop_size=10)
number = 3


def made(size=15):
    """Another of mine."""
    return Mine(pop_size=size)


def search(evaluator, seed, step=50):
    """Draws."""
    while True:
        evaluator.cost(evaluator.problem.sample_uniform(np.random.default_rng(seed), step))


class Drawing(Solver):
    """Draws, too."""

    name = title = ""

    def __init__(self, step=10):
        self.step = step

    def search(self, evaluator, seed):
        search(evaluator, seed, self.step)

    def refuses(self, problem):
        return "too cold" if problem.dimension > 9 else None


class Idle(Algorithm):
    """Goes round in circles."""

    def _initialize_infill(self):
        return None

    def _post_advance(self):
        pass


class Counting(Solver):
    """Remembers how often it searched."""

    title = "Counts"
    searched = 0

    def search(self, evaluator, seed):
        self.searched += 1
        problem = evaluator.problem
        evaluator.cost((problem.lower + (problem.upper - problem.lower) / (1 + self.searched))[None])


counting = Counting()


def returning(evaluator, seed):
    """Tries one candidate."""
    evaluator.cost(evaluator.problem.sample_uniform(np.random.default_rng(seed)))


def leaving(evaluator, seed):
    """Tries one candidate and leaves."""
    evaluator.cost(evaluator.problem.sample_uniform(np.random.default_rng(seed)))
    raise SystemExit(3)


def failing():
    raise RuntimeError("no")
'''


@pytest.fixture(scope="module")
def mine(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("mine")
    (folder / "written_by_me.py").write_text(OWN)
    (folder / "broken_by_me.py").write_text("raise SystemExit('bye')\n")
    yield folder
    sys.modules.pop("written_by_me", None)


@pytest.fixture
def here(mine: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", sys.path[:])
    monkeypatch.chdir(mine)


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    ("attribute", "title"),
    [
        ("Mine", "A genetic algorithm of mine"),
        ("Mine:pop_size=12:eliminate_duplicates=false", "A genetic algorithm of mine"),
        ("instance", "A genetic algorithm of mine"),
        ("made:size=11", "Another of mine"),
        ("search", "Draws"),
        ("search:step=20", "Draws"),
        ("Drawing", "Draws, too"),
        ("Drawing:step=7", "Draws, too"),
    ],
)
def test_ones_own_takes_part_from_the_current_directory(attribute: str, title: str) -> None:
    text = f"written_by_me:{attribute}"
    first, again = (ran(text, Sphere().problem(), budget=300) for _ in range(2))
    assert (first.algorithm, find(text).title, first.state, first.reason) == (text, title, DONE, "")
    assert first.evaluations == 300
    assert np.array_equal(first.trace.costs, again.trace.costs)


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("attribute", ["Counting", "counting"])
def test_no_run_knows_of_another(attribute: str) -> None:
    solver = find(f"written_by_me:{attribute}")
    runs = [run(Sphere().problem(), solver, seed=1, budget=300, time_limit_s=60.0) for _ in range(2)]
    assert runs[0].trace.costs.tolist() == runs[1].trace.costs.tolist()
    assert len(runs[0].trace.costs) == 1
    assert solver.title == "Counts"


@pytest.mark.usefixtures("here")
def test_ones_own_begins_anew_with_another_seed_whenever_it_returns() -> None:
    made = ran("written_by_me:returning", Sphere().problem(), budget=50)
    assert (made.state, made.evaluations) == (DONE, 50)
    assert len(made.trace.costs) > 1


@pytest.mark.usefixtures("here")
def test_who_leaves_has_failed_and_keeps_what_it_found() -> None:
    made = ran("written_by_me:leaving", Sphere().problem(), budget=50)
    assert (made.state, made.reason) == (FAILED, "it called sys.exit(3)")
    assert made.evaluations == 1
    assert np.isfinite(made.trace.final)


@pytest.mark.usefixtures("here")
def test_ones_own_may_refuse() -> None:
    assert find("written_by_me:Drawing").refuses(Sphere(10).problem()) == "too cold"
    assert find("written_by_me:Drawing").refuses(Sphere(9).problem()) is None
    assert find("written_by_me:search").refuses(Sphere(10).problem()) is None


@pytest.mark.usefixtures("here")
def test_a_solver_that_never_evaluates_is_stopped() -> None:
    made = ran("written_by_me:Idle", Sphere().problem())
    assert (made.state, made.evaluations) == (FAILED, 0)
    assert "iterations without" in made.reason


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize(
    ("text", "error", "said"),
    [
        ("dee", UsageError, "Did you mean 'de'?"),
        ("gauss-newton", UsageError, "There are: screening"),
        ("ga:popsize=3", UsageError, "Did you mean 'pop_size'?"),
        ("random:b=2", UsageError, "There are: none"),
        ("ga:pop_size=1.5", UsageError, "a whole number of at least 2"),
        ("ga:pop_size=true", UsageError, "a whole number"),
        ("pycma:sigma=nan", UsageError, "a number of at least 0"),
        ("ga:crossover=pxc", UsageError, "sbx, arithmetic"),
        ("ga:mutation.b=3", UsageError, "mutation.eta"),
        ("rcga:pop_size=5:n_elites=5", UsageError, "below pop_size"),
        ("ga:survival=elitist:pop_size=8", UsageError, "fewer than pop_size"),
        ("ga:", UsageError, "NAME"),
        ("", UsageError, "NAME"),
        ("rcga:b", UsageError, "'b' is not a setting"),
        ("ga:b=", UsageError, "'b=' is not a setting"),
        ("ga:pop_size=2:x", UsageError, "'x' is not a setting"),
        ("ga:b=1:b=2", UsageError, "twice"),
        ("nowhere.at.all:GA", UsageError, "current directory"),
        ("broken_by_me:GA", UsageError, "bye"),
        ("written_by_me:made_up", UsageError, "Did you mean 'made'?"),
        ("written_by_me:number.of", UsageError, "real"),
        ("written_by_me:number", UsageError, "search(evaluator, seed)"),
        ("builtins:dict", UsageError, "{} and cannot search"),
        ("written_by_me:failing", UsageError, "RuntimeError: no"),
        ("written_by_me:np.pi", UsageError, "cannot search"),
        ("written_by_me:Mine:popsize=3", UsageError, "Did you mean 'pop_size'?"),
        ("written_by_me:search:stop=3", UsageError, "Did you mean 'step'?"),
        ("written_by_me:instance:pop_size=3", UsageError, "There are: none"),
    ],
)
def test_what_makes_no_sense_is_said(text: str, error: type[Exception], said: str) -> None:
    with pytest.raises(error) as caught:
        find(text)
    assert said in str(caught.value)
