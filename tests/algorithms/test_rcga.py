"""The paper's genetic algorithm finds, keeps, stops and plugs into pymoo."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from pymoo.algorithms.soo.nonconvex.ga import FitnessSurvival
from pymoo.core.parameters import get_params
from pymoo.core.population import Population
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.core.termination import TerminateIfAny
from pymoo.core.variable import Real
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.operators.selection.rnd import RandomSelection
from pymoo.optimize import minimize
from pymoo.problems import get_problem
from pymoo.termination import get_termination

from robolaser.algorithms import RCGA, Stalled
from robolaser.errors import AlgorithmError

SPHERE = get_problem("sphere", n_var=6)
RASTRIGIN = get_problem("rastrigin", n_var=2)


class Pit(Problem):
    """Not a number in half the space, infinite in a part, a bowl elsewhere; the last variable has no room."""

    def __init__(self):
        super().__init__(n_var=3, n_obj=1, xl=np.array([-1.0, -1.0, 2.0]), xu=np.array([1.0, 1.0, 2.0]))

    def _evaluate(self, X, out, *args, **kwargs):
        cost = ((X[:, :2] - 0.2) ** 2).sum(axis=1)
        out["F"] = np.where(X[:, 0] < 0.0, np.nan, np.where(X[:, 1] > 0.8, np.inf, cost))[:, None]


class Fenced(Problem):
    """A bowl whose bottom lies behind a constraint."""

    def __init__(self):
        super().__init__(n_var=2, n_obj=1, n_ieq_constr=1, xl=-1.0, xu=1.0)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = (X**2).sum(axis=1, keepdims=True)
        out["G"] = 1.0 - X.sum(axis=1, keepdims=True)


def bests(algorithm, problem=SPHERE, termination=("n_gen", 40), **kwargs):
    seen = []
    found = minimize(problem, algorithm, termination, seed=3, callback=lambda a: seen.append(a.opt[0].F[0]), **kwargs)
    return np.array(seen), found


def test_it_finds_the_bottom_of_a_bowl():
    assert bests(RCGA(pop_size=40), termination=("n_gen", 150))[1].F[0] < 1e-8


def test_it_finds_the_deepest_of_many_valleys():
    assert bests(RCGA(pop_size=60), RASTRIGIN, ("n_gen", 150))[1].F[0] < 1e-3


def test_the_best_is_never_lost():
    for n_elites in (1, 2, 7):
        seen, found = bests(RCGA(pop_size=20, n_elites=n_elites), RASTRIGIN)
        assert np.all(np.diff(seen) <= 0.0)
        assert found.F[0] == seen[-1] == found.pop.get("F").min()


def test_elites_pass_untouched():
    algorithm = RCGA(pop_size=20, n_elites=4).setup(SPHERE, termination=("n_gen", 10), seed=1)
    algorithm.next()
    for _ in range(9):
        before = algorithm.pop[np.argsort(algorithm.pop.get("F")[:, 0], kind="stable")[:4]]
        algorithm.next()
        assert all(a is b for a, b in zip(algorithm.pop[:4], before, strict=True))
        assert len(algorithm.pop) == 20
        assert len(algorithm.off) == 16


@pytest.mark.parametrize(("pop_size", "n_elites"), [(1, 0), (2, 1), (5, 2), (7, 0), (20, 19), (33, None)])
def test_any_size_keeps_its_size_and_counts_its_evaluations(pop_size, n_elites):
    found = minimize(SPHERE, RCGA(pop_size=pop_size, n_elites=n_elites), ("n_gen", 6), seed=1)
    elites = found.algorithm.survival.n_elites
    assert len(found.pop) == pop_size
    assert found.algorithm.evaluator.n_eval == pop_size + 5 * (pop_size - elites)


def test_the_same_seed_gives_the_same_run_and_another_another():
    first, again = bests(RCGA(pop_size=20))[0], bests(RCGA(pop_size=20))[0]
    assert np.array_equal(first, again)
    assert minimize(SPHERE, RCGA(pop_size=20), ("n_gen", 40), seed=4).F[0] != first[-1]


def test_a_run_is_its_seed_and_the_documented_draws():
    """One generation by hand, from the docstring alone."""
    N, E, d = 10, 3, 6
    algorithm = RCGA(pop_size=N, n_elites=E, prob_var=0.3, b=2.0).setup(SPHERE, termination=("n_gen", 8), seed=5)
    algorithm.next()
    algorithm.next()

    rng = np.random.default_rng(5)
    X = SPHERE.xl + (SPHERE.xu - SPHERE.xl) * rng.random((N, d))
    J = ((X - 0.5) ** 2).sum(axis=1)
    M = 4
    wheel = np.cumsum(1.0 / J)
    a, b = X[np.searchsorted(wheel / wheel[-1], rng.random((M, 2)))].swapaxes(0, 1)
    share = np.where((rng.random(M) < 0.85)[:, None], rng.random((M, 1)), 1.0)
    Y = np.concatenate([share * a + (1 - share) * b, share * b + (1 - share) * a])
    mutated = rng.random(Y.shape) < 0.3
    up = rng.random(mutated.sum()) < 0.5
    step = rng.random(mutated.sum()) * (1 - 1 / 8) ** 2.0
    Y[mutated] += np.where(up, 1.0 - Y[mutated], 0.0 - Y[mutated]) * step
    expected = np.concatenate([X[np.argsort(J)[:E]], Y[: N - E]])
    np.testing.assert_allclose(algorithm.pop.get("X"), expected, rtol=1e-14)


def test_in_the_last_generation_mutation_moves_next_to_nothing():
    algorithm = RCGA(pop_size=20, n_elites=2, prob_crossover=0.0, prob_var=1.0)
    algorithm.setup(SPHERE, termination=("n_gen", 30), seed=1)
    for _ in range(29):
        algorithm.next()
    parents = algorithm.pop.get("X")
    algorithm.next()
    moved = np.abs(algorithm.off.get("X")[:, None] - parents[None]).max(axis=2).min(axis=1)
    assert np.all(moved <= (1 / 30) ** 5)
    assert np.any(moved > 0)


def test_costs_that_are_not_finite_are_bad_and_no_more():
    seen, found = bests(RCGA(pop_size=30), Pit(), ("n_gen", 60))
    assert np.all(np.isfinite(seen))
    assert pytest.approx([0.2, 0.2, 2.0], abs=1e-3) == found.X
    assert found.X[2] == 2.0


def test_constraints_are_kept():
    found = bests(RCGA(pop_size=40), Fenced(), ("n_gen", 100))[1]
    assert found.F[0] == pytest.approx(0.5, abs=0.01)
    assert found.X.sum() >= 1.0


def test_costs_below_zero_are_minimised_too():
    class Sunk(Problem):
        def __init__(self):
            super().__init__(n_var=2, n_obj=1, xl=-1.0, xu=1.0)

        def _evaluate(self, X, out, *args, **kwargs):
            out["F"] = ((X - 0.3) ** 2).sum(axis=1, keepdims=True) - 7.0

    assert bests(RCGA(pop_size=30), Sunk(), ("n_gen", 80))[1].F[0] == pytest.approx(-7.0, abs=1e-5)


def test_the_settings_of_the_paper_are_the_defaults():
    algorithm = RCGA()
    mating, survival = algorithm.mating, algorithm.survival
    assert (algorithm.pop_size, algorithm.n_offsprings, survival.n_elites) == (100, 90, 10)
    assert mating.crossover.prob.value == 0.85
    assert (mating.mutation.prob_var.value, mating.mutation.b.value) == (0.1, 5.0)
    assert isinstance(algorithm.termination, Stalled)
    assert algorithm.termination.generations == 10_000


def test_pymoos_tuning_finds_its_numbers_and_they_come_into_force():
    algorithm = RCGA(pop_size=20)
    tunable = get_params(algorithm)["mating"]
    tunable["mutation"]["prob_var"].value = 0.0
    tunable["crossover"]["prob"].value = 0.0
    seen, _ = bests(algorithm)
    assert np.all(seen == seen[0])


def test_it_stops_once_the_cost_is_reached():
    seen, found = bests(RCGA(pop_size=30), termination=("fmin", 1e-2))
    assert seen[-1] <= 1e-2 < seen[-2]
    assert found.algorithm.termination.has_terminated()


def test_it_stops_when_nothing_gets_better_for_long_enough():
    class Flat(Problem):
        def __init__(self):
            super().__init__(n_var=2, n_obj=1, xl=0.0, xu=1.0)

        def _evaluate(self, X, out, *args, **kwargs):
            out["F"] = np.ones((len(X), 1))

    seen, _ = bests(RCGA(pop_size=6, termination=Stalled(12)), Flat(), None)
    assert len(seen) == 1 + 12


def test_a_stall_is_counted_from_the_last_better_cost():
    seen, _ = bests(RCGA(pop_size=10, termination=Stalled(15)), RASTRIGIN, None)
    last_better = 1 + np.flatnonzero(np.diff(seen) < 0)[-1]
    assert len(seen) - 1 - last_better == 15


def test_a_stall_counts_from_the_best_ever_where_the_algorithm_loses_it():
    stalled = Stalled(3)
    for generation, cost in enumerate([5.0, 4.0, 6.0, 4.5, 4.0], start=1):
        best = Population.new(X=np.zeros((1, 6)), F=np.array([[cost]]))
        stalled.update(SimpleNamespace(problem=SPHERE, n_iter=generation, opt=best))
        assert stalled.has_terminated() == (generation == 5)


def test_its_terminations_combine_with_pymoos():
    either = TerminateIfAny(Stalled(1000), get_termination("fmin", 1e-30), get_termination("n_gen", 9))
    assert len(bests(RCGA(pop_size=10), termination=either)[0]) == 9


def test_evaluation_and_time_budgets_end_a_run():
    found = bests(RCGA(pop_size=20, n_elites=2), termination=("n_eval", 200))[1]
    assert found.algorithm.evaluator.n_eval == 200
    assert bests(RCGA(pop_size=20), termination=("time", 0.1))[1].algorithm.termination.has_terminated()


@pytest.mark.parametrize(
    ("setting", "value"),
    [("pop_size", 0), ("n_elites", 20), ("n_elites", -1), ("prob_crossover", 1.2), ("prob_var", -0.1), ("b", -1)],
)
def test_settings_without_meaning_are_refused(setting, value):
    with pytest.raises(AlgorithmError, match=f"{setting} is {value}"):
        RCGA(**{"pop_size": 20, setting: value})


def test_a_setting_that_nothing_takes_is_refused():
    with pytest.raises(AlgorithmError, match="no setting 'patience'"):
        RCGA(patience=12)


def test_problems_it_cannot_search_are_refused():
    with pytest.raises(AlgorithmError, match="the problem has 2"):
        RCGA().setup(get_problem("zdt1"))
    with pytest.raises(AlgorithmError, match="finite xl and xu"):
        RCGA().setup(Problem(n_var=2, n_obj=1))


def test_the_polish_loads_without_pymoo():
    code = "import sys, robolaser.estimation.solver; sys.exit('pymoo' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("replaced", ["crossover", "mutation", "selection", "survival"])
def test_an_operator_given_at_the_start_is_the_one_put_in_later(replaced):
    other = {
        "crossover": lambda: SBX(eta=5),
        "mutation": lambda: PM(eta=10),
        "selection": RandomSelection,
        "survival": FitnessSurvival,
    }[replaced]
    given = RCGA(pop_size=12, **{replaced: other()})
    later = RCGA(pop_size=12, n_elites=0) if replaced == "survival" else RCGA(pop_size=12)
    setattr(later if replaced == "survival" else later.mating, replaced, other())
    first, second = (minimize(SPHERE, one, ("n_gen", 12), seed=3) for one in (given, later))
    assert np.array_equal(first.pop.get("X"), second.pop.get("X"))


def test_duplicates_are_eliminated_and_children_counted_as_in_pymoo():
    run = minimize(SPHERE, RCGA(pop_size=10, n_offsprings=3, eliminate_duplicates=True), ("n_gen", 5), seed=1)
    assert run.algorithm.evaluator.n_eval == 10 + 4 * 3
    X = run.pop.get("X")
    assert len(np.unique(X, axis=0)) == len(X)


@pytest.mark.parametrize(
    ("setting", "part"),
    [
        ({"prob_crossover": 0.5}, {"crossover": SBX()}),
        ({"b": 2.0}, {"mutation": PM()}),
        ({"n_elites": 3}, {"survival": FitnessSurvival()}),
    ],
)
def test_a_setting_of_an_operator_that_is_replaced_is_refused_by_name(setting, part):
    with pytest.raises(AlgorithmError, match=f"{next(iter(setting))} belongs to the paper's {next(iter(part))}"):
        RCGA(pop_size=10, **setting, **part)


def test_variables_declared_one_by_one_are_refused_in_a_sentence():
    problem = ElementwiseProblem(vars={"a": Real(bounds=(0, 1)), "b": Real(bounds=(0, 1))}, n_obj=1)
    with pytest.raises(AlgorithmError, match="MixedVariableGA"):
        RCGA(pop_size=10).setup(problem, termination=("n_gen", 2), seed=1)


def test_elites_are_counted_from_the_parents_that_there_are():
    start = np.random.default_rng(0).uniform(-1, 1, (10, SPHERE.n_var))
    algorithm = RCGA(pop_size=100, n_elites=2, sampling=start).setup(SPHERE, termination=("n_gen", 3), seed=1)
    algorithm.next()
    algorithm.next()
    kept = (algorithm.pop.get("X")[:, None] == start[None]).all(-1).any(0).sum()
    assert len(algorithm.pop) == 100
    assert kept == 2
