"""RCGA goes from array to array: the same run as pymoo's own parts make, whoever looks at it and however often."""

import copy
import pickle

import numpy as np
import pytest
from every_problem import ALL, SPHERE, Bowl, Fenced, Holed
from pymoo.constraints.eps import AdaptiveEpsilonConstraintHandling
from pymoo.core.evaluator import Evaluator
from pymoo.core.individual import Individual
from pymoo.core.population import Population
from pymoo.core.repair import Repair
from pymoo.operators.mutation.pm import PM
from pymoo.operators.sampling.lhs import LHS
from pymoo.optimize import minimize
from pymoo.termination import get_termination
from pymoo.util.archive import SingleObjectiveArchive
from stock import composed

from robolaser.algorithms import RCGA

SETTINGS = [
    {"pop_size": 20, "n_elites": 2},
    {"pop_size": 20, "n_elites": 3, "prob_var": 0.5},
    {"pop_size": 15, "n_elites": 0, "b": 2.0},
    {"pop_size": 12, "n_elites": 11, "prob_crossover": 0.0},
    {"pop_size": 13, "n_elites": 4, "prob_crossover": 1.0, "prob_var": 0.0},
    {"pop_size": 2, "n_elites": 1, "b": 7.0},
]
T = 20


def said(pop):
    """All that a population says of itself, not a number counted as infinite."""
    X, F, G, H, CV, born = pop.get("X", "F", "G", "H", "CV", "n_gen")
    return np.hstack([X, np.where(np.isnan(F), np.inf, F), G, H, CV, born[:, None]])


def started(algorithm, problem=SPHERE, termination=("n_gen", T), **kwargs):
    return algorithm.setup(problem, termination=termination, seed=3, **kwargs)


def steps(algorithm, n=T, look=lambda algorithm: None):
    """What a run leaves behind, generation by generation."""
    left = []
    for _ in range(n):
        algorithm.next()
        left.append(np.hstack([said(algorithm.pop).ravel(), algorithm.evaluator.n_eval, algorithm.n_iter]))
        look(algorithm)
    return np.array(left)


def last(algorithm, n=T):
    """The last generation of a run that nobody looked at."""
    for _ in range(n):
        algorithm.next()
    return said(algorithm.pop)


@pytest.mark.parametrize("problem", ALL, ids=lambda problem: type(problem).__name__)
@pytest.mark.parametrize("settings", SETTINGS, ids=lambda settings: f"{settings['pop_size']}-{settings['n_elites']}")
def test_a_run_is_that_of_pymoos_parts_to_the_last_bit(problem, settings):
    ours, theirs = started(RCGA(**settings), problem), started(composed(**settings), problem)
    assert np.array_equal(last(ours), last(theirs))
    assert np.array_equal(said(ours.off), said(theirs.off))
    assert ours.evaluator.n_eval == theirs.evaluator.n_eval


@pytest.mark.parametrize("problem", ALL, ids=lambda problem: type(problem).__name__)
def test_who_looks_at_every_generation_sees_that_of_pymoos_parts(problem):
    ours, theirs = started(RCGA(14, n_elites=3), problem), started(composed(14, 3), problem)

    def look(algorithm):
        assert algorithm.opt[0] in list(algorithm.pop)
        assert sum(one in list(algorithm.pop) for one in algorithm.off) >= 11
        assert algorithm.pop is algorithm.pop

    assert np.array_equal(steps(ours, look=look), steps(theirs, look=look))
    assert all(a.evaluated == b.evaluated for a, b in zip(ours.pop, theirs.pop, strict=True))
    for name in ("length", "square"):
        assert np.array_equal(ours.pop.get(name), theirs.pop.get(name))
    for name in ("X", "F", "G", "H", "CV", "feas"):
        if type(problem) is not Holed:
            assert np.array_equal(ours.opt.get(name), theirs.opt.get(name))


def test_no_individual_is_made_until_somebody_asks(monkeypatch):
    made = []
    begin = Individual.__init__
    monkeypatch.setattr(Individual, "__init__", lambda self, *a, **k: made.append(self) or begin(self, *a, **k))
    algorithm = started(RCGA(20), callback=lambda algorithm: algorithm.n_gen)
    algorithm.next()
    made.clear()
    while algorithm.has_next():
        algorithm.next()
    assert not made
    assert len(algorithm.opt) == len(made) == 1
    assert algorithm.opt[0] in list(algorithm.pop)
    assert algorithm.off[0] in made


def test_who_looks_now_and_then_changes_nothing():
    seen = started(RCGA(16))
    for generation in range(T):
        seen.next()
        match generation % 5:
            case 1:
                assert seen.opt[0].F[0] == seen.arrays[1].min()
            case 2:
                assert len(seen.off) == 14
            case 3:
                assert len(seen.pop) == 16
    assert np.array_equal(said(seen.pop), last(started(RCGA(16))))


@pytest.mark.parametrize("make", [lambda: RCGA(16, n_elites=4), lambda: composed(16, 4)])
def test_what_is_changed_in_one_that_was_handed_out_holds(make):
    algorithm = started(make(), Bowl())
    algorithm.next()
    worst = algorithm.pop[algorithm.pop.get("F")[:, 0].argmax()]
    worst.F = np.array([-1e6])
    algorithm.next()
    assert algorithm.pop[0] is worst
    assert algorithm.opt[0] is worst
    assert algorithm.opt[0].F[0] == -1e6


@pytest.mark.parametrize("problem", [SPHERE, Fenced()], ids=["free", "constrained"])
def test_asking_and_telling_makes_the_same_run(problem):
    by_asking, mixed = started(RCGA(16), problem), started(RCGA(16), problem)
    left = []
    while by_asking.has_next():
        infills = by_asking.ask()
        by_asking.evaluator.eval(problem, infills)
        by_asking.tell(infills=infills)
        left.append(said(by_asking.pop))
    for generation in range(T):
        if generation % 3:
            mixed.next()
        else:
            infills = mixed.ask()
            mixed.evaluator.eval(problem, infills)
            mixed.tell(infills=infills)
        assert generation % 2 or np.array_equal(said(mixed.pop), left[generation])
    assert np.array_equal(last(started(RCGA(16), problem)), left[-1])


def test_a_run_goes_on_from_a_copy_and_from_another_process():
    algorithm = started(RCGA(16), Fenced())
    last(algorithm, 9)
    copies = [copy.copy(algorithm), copy.deepcopy(algorithm), pickle.loads(pickle.dumps(algorithm))]
    copies[0].random_state, copies[0].evaluator = map(copy.deepcopy, (algorithm.random_state, algorithm.evaluator))
    expected = last(algorithm, 9)
    assert all(np.array_equal(last(one, 9), expected) for one in copies)


def test_history_keeps_every_generation():
    found = minimize(SPHERE, RCGA(16), ("n_gen", T), seed=3, save_history=True)
    assert np.array_equal([said(entry.pop).ravel() for entry in found.history], steps(started(RCGA(16)))[:, :-2])
    assert [entry.opt[0].F[0] for entry in found.history] == [entry.pop.get("F").min() for entry in found.history]


def test_the_result_says_what_pymoos_says():
    for problem in (SPHERE, Fenced()):
        ours, theirs = (minimize(problem, make, ("n_gen", T), seed=3) for make in (RCGA(16), composed(16, 2)))
        for name in ("X", "F", "G", "H", "CV"):
            assert np.array_equal(getattr(ours, name), getattr(theirs, name))
        assert ours.exec_time > 0.0
        assert type(ours.pop) is type(ours.opt) is Population
        assert ours.algorithm.n_gen == theirs.algorithm.n_gen
    hopeless = Fenced()
    hopeless.xu = np.array([0.0, 1.0, 1e-9, 3.0])
    assert minimize(hopeless, RCGA(16), ("n_gen", 3), seed=3).F is None
    assert minimize(hopeless, RCGA(16), ("n_gen", 3), seed=3, return_least_infeasible=True).CV[0] > 0.0


def test_the_display_shows_what_it_shows_of_pymoos(capsys):
    shown = []
    for make in (RCGA(16), composed(16, 2)):
        minimize(Fenced(), make, ("n_gen", 8), seed=3, verbose=True, output=RCGA().output)
        shown.append(capsys.readouterr().out)
    assert shown[0] == shown[1]
    assert len(shown[0].splitlines()) == 3 + 8


def test_an_archive_holds_the_best():
    found = minimize(SPHERE, RCGA(16), ("n_gen", T), seed=3, archive=SingleObjectiveArchive())
    assert found.archive[0] is found.opt[0]


@pytest.mark.parametrize("rule", [("n_eval", 333), ("fmin", 0.02), ("soo", 1e-2, 1e-2, 1e-2, 5)])
def test_pymoos_own_rules_stop_it_where_they_stop_pymoos(rule):
    ours, theirs = (minimize(SPHERE, make, get_termination(*rule), seed=3) for make in (RCGA(16), composed(16, 2)))
    assert ours.algorithm.n_gen == theirs.algorithm.n_gen
    assert np.array_equal(said(ours.pop), said(theirs.pop))


class Doubling(Evaluator):
    """Somebody's own way to evaluate."""

    def _eval(self, problem, pop, evaluate_values_of, **kwargs):
        super()._eval(problem, pop, evaluate_values_of, **kwargs)
        pop.set("F", 2.0 * pop.get("F"))


def test_an_evaluator_of_ones_own_is_used():
    assert np.array_equal(
        last(started(RCGA(16), evaluator=Doubling())), last(started(composed(16, 2), evaluator=Doubling()))
    )
    sizes = []
    last(started(RCGA(16), evaluator=Evaluator(callback=lambda pop: sizes.append(len(pop)))))
    assert sizes == [16] + (T - 1) * [14]


class Rounding(Repair):
    """Candidates on a grid only."""

    def _do(self, problem, X, **kwargs):
        return np.round(X, 2)


def test_parts_of_ones_own_are_used():
    assert np.array_equal(*(last(_changed(make)) for make in (RCGA(16), composed(16, 2))))
    X = last(started(RCGA(16, repair=Rounding())))[:, :6]
    assert np.array_equal(X, np.round(X, 2))


def _changed(algorithm):
    algorithm.mating.mutation = PM()
    return started(algorithm)


def test_handling_constraints_another_way_works_as_with_pymoos():
    ours, theirs = (AdaptiveEpsilonConstraintHandling(make) for make in (RCGA(16), composed(16, 2)))
    assert np.array_equal(steps(started(ours, Fenced())), steps(started(theirs, Fenced())))


@pytest.mark.parametrize("n", [5, 16, 40])
def test_it_starts_from_any_population(n):
    X = np.random.default_rng(1).uniform(-0.5, 1.5, (n, 6))
    evaluated = Evaluator().eval(SPHERE, Population.new(X=X))
    for start in (X, Population.new(X=X), evaluated, LHS()):
        ours, theirs = RCGA(16, sampling=copy.deepcopy(start)), composed(16, 2, sampling=copy.deepcopy(start))
        ours, theirs = started(ours), started(theirs)
        assert np.array_equal(last(ours), last(theirs))
        assert ours.evaluator.n_eval == theirs.evaluator.n_eval


def test_a_population_may_be_exchanged_on_the_way():
    runs = []
    for make in (RCGA(16), composed(16, 2)):
        algorithm = started(make)
        last(algorithm, 5)
        X = np.random.default_rng(1).random((16, 6))
        algorithm.pop = algorithm.evaluator.eval(SPHERE, Population.new(X=X))
        runs.append(last(algorithm, 5))
    assert np.array_equal(*runs)


def test_what_a_problem_keeps_is_not_what_it_gave_away():
    class Keeping(Bowl):
        def _evaluate(self, X, out, *args, **kwargs):
            super()._evaluate(X, out)
            self.F = out["F"] = out["F"] + 1.0

    algorithm = started(RCGA(16), Keeping())
    algorithm.next()
    algorithm.problem.F[:] = 0.0
    assert np.all(algorithm.pop.get("F") != 0.0)
