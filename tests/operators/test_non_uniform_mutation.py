"""Non-uniform mutation moves genes within their bounds, and ever less."""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from bowl import LOWER, UPPER, Bowl, running
from pymoo.algorithms.moo.moead import MOEAD
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination, TerminateIfAll, TerminateIfAny, Termination
from pymoo.optimize import minimize
from pymoo.termination import get_termination
from pymoo.termination.collection import TerminationCollection
from pymoo.termination.default import DefaultSingleObjectiveTermination
from pymoo.termination.ftol import SingleObjectiveSpaceTermination
from pymoo.termination.robust import RobustTermination
from pymoo.util.ref_dirs import get_reference_directions
from scipy import stats

from robolaser.errors import AlgorithmError
from robolaser.operators import NonUniformMutation
from robolaser.operators.non_uniform_mutation import HORIZON, non_uniform, step_size

FREE = [0, 1, 2, 4]
TREES = {
    "plain": get_termination("n_gen", 50),
    "any": TerminateIfAny(get_termination("time", 60), get_termination("n_gen", 50)),
    "all": TerminateIfAll(get_termination("n_eval", 60), get_termination("n_gen", 50)),
    "collection": TerminationCollection(get_termination("fmin", 1.0), get_termination("n_gen", 50)),
    "default": DefaultSingleObjectiveTermination(n_max_gen=50),
    "deep": TerminateIfAny(NoTermination(), TerminateIfAll(RobustTermination(get_termination("n_gen", 50)))),
    "the smallest of several": TerminateIfAny(get_termination("n_gen", 70), get_termination("n_gen", 50)),
}
progress = NonUniformMutation().progress_of


def mutate(mutation, X, problem=None, n_iter=1, seed=5, **told):
    pop = Population.new(X=X)
    told = told or {"algorithm": running(n_iter, get_termination("n_gen", 100))}
    rng = np.random.default_rng(seed)
    return mutation.do(Bowl() if problem is None else problem, pop, random_state=rng, **told).get("X")


@pytest.fixture(name="X")
def individuals():
    return np.random.default_rng(6).uniform(LOWER, UPPER, (4000, 5))


def test_mutants_stay_within_bounds_to_the_last_digit():
    rng = np.random.default_rng(7)
    lower = rng.standard_normal(10_000)
    upper = lower + 10.0 ** rng.uniform(-16, 3, 10_000)
    x = np.clip(lower + rng.random(10_000) * (upper - lower), lower, upper)
    for upward in (np.ones(10_000, bool), np.zeros(10_000, bool)):
        for share in (np.ones(10_000), step_size(rng.random(10_000), 0.0, 5.0)):
            y = non_uniform(x, lower, upper, upward, share)
            assert np.all((y >= lower) & (y <= upper))
            assert np.all(y >= x) if upward[0] else np.all(y <= x)


def test_a_full_step_reaches_the_bound():
    x, lower, upper = np.zeros(1), np.array([-3.0]), np.array([5.0])
    assert non_uniform(x, lower, upper, np.array([True]), np.ones(1)) == upper
    assert non_uniform(x, lower, upper, np.array([False]), np.ones(1)) == lower


def test_at_the_last_generation_nothing_moves(X):
    mutation = NonUniformMutation(prob_var=1.0)
    assert np.array_equal(mutate(mutation, X, n_iter=101), X)
    assert np.array_equal(mutate(mutation, X, n_iter=1000), X)


@pytest.mark.parametrize("n_iter", [1, 26, 51])
def test_steps_are_distributed_as_the_equation_says(X, n_iter):
    b, rest = 2.0, 1.0 - (n_iter - 1) / 100
    Y = mutate(NonUniformMutation(prob_var=1.0, b=b), X, n_iter=n_iter)
    ahead = np.where(Y > X, UPPER - X, X - LOWER)[:, 0]
    assert stats.kstest((np.abs(Y - X)[:, 0] / ahead) / rest**b, "uniform").pvalue > 0.01


def test_up_and_down_are_equally_likely(X):
    up = (mutate(NonUniformMutation(prob_var=1.0), X) > X)[:, FREE]
    assert stats.binomtest(int(up.sum()), up.size).pvalue > 0.01


def test_the_rate_counts_genes(X):
    moved = (mutate(NonUniformMutation(prob_var=0.1), X) != X)[:, FREE]
    assert stats.binomtest(int(moved.sum()), moved.size, 0.1).pvalue > 0.01
    assert 0.05 < moved.any(axis=1).mean() < 0.5


def test_without_probability_nothing_moves(X):
    assert np.array_equal(mutate(NonUniformMutation(prob_var=0.0), X), X)
    assert np.array_equal(mutate(NonUniformMutation(prob_var=1.0, prob=0.0), X), X)


def test_genes_without_room_stay(X):
    assert np.all(mutate(NonUniformMutation(prob_var=1.0), X)[:, 3] == 2.0)


def test_individuals_from_outside_are_brought_in(X):
    Y = mutate(NonUniformMutation(prob_var=0.5), X + 0.3 * (UPPER - LOWER))
    assert np.all((Y >= LOWER) & (Y <= UPPER))


def test_whole_numbers_become_real():
    problem = Problem(n_var=2, n_obj=1, xl=0, xu=10)
    Y = mutate(NonUniformMutation(prob_var=1.0), np.full((50, 2), 5), problem)
    assert np.any(np.round(Y) != Y)


def test_without_the_time_it_says_what_to_do(X):
    with pytest.raises(AlgorithmError, match=r"NonUniformMutation\(progress="):
        mutate(NonUniformMutation(), X, algorithm=None)


def test_an_explicit_progress_needs_no_algorithm(X):
    assert np.array_equal(mutate(NonUniformMutation(prob_var=1.0, progress=1.0), X, algorithm=None), X)
    told = mutate(NonUniformMutation(progress=lambda: 0.25), X, algorithm=None)
    assert np.array_equal(told, mutate(NonUniformMutation(), X, n_iter=26))


def test_a_callback_can_tell_the_time_where_the_algorithm_does_not():
    done = {"share": 0.0}
    told = []

    def progress():
        told.append(done["share"])
        return done["share"]

    def tell(algorithm):
        done["share"] = algorithm.n_iter / 5

    directions = get_reference_directions("uniform", 2, n_partitions=5)
    algorithm = MOEAD(directions, n_neighbors=3, mutation=NonUniformMutation(progress=progress))
    minimize(Bowl(n_obj=2), algorithm, ("n_gen", 5), seed=1, callback=tell)
    assert sorted(set(told)) == [0.2, 0.4, 0.6, 0.8]


@pytest.mark.parametrize("bounds", [{}, {"xl": np.array([0.0, -np.inf]), "xu": np.ones(2)}], ids=["none", "infinite"])
def test_a_problem_without_bounds_is_refused(bounds):
    with pytest.raises(AlgorithmError, match="finite xl and xu"):
        mutate(NonUniformMutation(), np.zeros((4, 2)), Problem(n_var=2, n_obj=1, **bounds))


@pytest.mark.parametrize(
    "setting",
    [
        {"b": -1.0},
        {"b": np.nan},
        {"prob_var": 1.5},
        {"prob_var": -0.1},
        {"prob": 2},
        {"progress": 2},
        {"progress": np.nan},
    ],
)
def test_settings_without_meaning_are_refused(setting):
    with pytest.raises(AlgorithmError, match=f"{next(iter(setting))} is"):
        NonUniformMutation(**setting)


@pytest.mark.parametrize("termination", TREES.values(), ids=TREES.keys())
def test_a_last_generation_is_found_anywhere(termination):
    assert progress(running(1, termination)) == 0.0
    assert progress(running(11, termination)) == pytest.approx(10 / 50)
    assert progress(running(51, termination)) == 1.0
    assert progress(running(99, termination)) == 1.0


def shares(termination, **kwargs):
    seen = []

    class Watched(GA):
        def _infill(self):
            seen.append(progress(self))
            return super()._infill()

    minimize(Bowl(), Watched(pop_size=10, eliminate_duplicates=False), termination, seed=1, **kwargs)
    return seen


def test_the_end_that_comes_first_counts():
    first_by_evaluations = TerminateIfAny(get_termination("n_gen", 2000), get_termination("n_eval", 50))
    first_by_generations = TerminateIfAny(get_termination("n_gen", 5), get_termination("n_eval", 50_000))
    assert shares(first_by_evaluations) == pytest.approx([0.2, 0.4, 0.6, 0.8])
    assert shares(first_by_generations) == pytest.approx([0.2, 0.4, 0.6, 0.8])


def test_a_time_budget_is_a_clock(monkeypatch):
    ticks = itertools.count(100.0, 0.5)
    monkeypatch.setattr("time.time", lambda: next(ticks))
    assert shares(("time", 2)) == pytest.approx([0.25, 0.5, 0.75])


def test_without_an_end_the_papers_horizon_holds():
    assert progress(running(HORIZON // 4 + 1, NoTermination())) == 0.25
    assert progress(running(HORIZON // 4 + 1, get_termination("n_gen", float("inf")))) == 0.25


def test_how_little_changes_is_no_clock():
    idle = SingleObjectiveSpaceTermination()
    idle.perc = 0.99
    assert progress(running(101, RobustTermination(idle))) == 100 / HORIZON


def test_a_termination_of_unknown_kind_is_believed():
    class Mine(Termination):
        pass

    mine = Mine()
    mine.perc = 0.4
    assert progress(running(1, TerminateIfAny(mine))) == 0.4
    assert progress(SimpleNamespace(n_iter=1, termination=SimpleNamespace(perc=0.5))) == 0.5
