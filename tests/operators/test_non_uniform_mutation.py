"""Non-uniform mutation moves genes within their bounds, and ever less."""

import numpy as np
import pytest
from bowl import LOWER, UPPER, Bowl, running
from pymoo.algorithms.moo.moead import MOEAD
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.optimize import minimize
from pymoo.termination import get_termination
from pymoo.util.ref_dirs import get_reference_directions
from scipy import stats

from robolaser.errors import AlgorithmError
from robolaser.operators import NonUniformMutation
from robolaser.operators.non_uniform_mutation import non_uniform, step_size

FREE = [0, 1, 2, 4]


def mutate(mutation, X, problem=None, n_iter=1, seed=5, **told):
    pop = Population.new(X=X)
    told = told or {"algorithm": running(n_iter, get_termination("n_gen", 100))}
    rng = np.random.default_rng(seed)
    return mutation.do(Bowl() if problem is None else problem, pop, random_state=rng, **told).get("X")


@pytest.fixture(name="X")
def individuals():
    return np.random.default_rng(6).uniform(LOWER, UPPER, (4000, 5))


@pytest.fixture(params=["linear", "power"])
def form(request):
    return request.param


def test_mutants_stay_within_bounds_to_the_last_digit(form):
    rng = np.random.default_rng(7)
    lower = rng.standard_normal(10_000)
    upper = lower + 10.0 ** rng.uniform(-16, 3, 10_000)
    x = np.clip(lower + rng.random(10_000) * (upper - lower), lower, upper)
    for upward in (np.ones(10_000, bool), np.zeros(10_000, bool)):
        for share in (np.ones(10_000), step_size(rng.random(10_000), 0.0, 5.0, form)):
            y = non_uniform(x, lower, upper, upward, share)
            assert np.all((y >= lower) & (y <= upper))
            assert np.all(y >= x) if upward[0] else np.all(y <= x)


def test_a_full_step_reaches_the_bound():
    x, lower, upper = np.zeros(1), np.array([-3.0]), np.array([5.0])
    assert non_uniform(x, lower, upper, np.array([True]), np.ones(1)) == upper
    assert non_uniform(x, lower, upper, np.array([False]), np.ones(1)) == lower


def test_at_the_last_generation_nothing_moves(X, form):
    mutation = NonUniformMutation(prob_var=1.0, form=form)
    assert np.array_equal(mutate(mutation, X, n_iter=101), X)
    assert np.array_equal(mutate(mutation, X, n_iter=1000), X)


@pytest.mark.parametrize("n_iter", [1, 26, 51])
def test_steps_are_distributed_as_the_form_says(X, form, n_iter):
    b, rest = 2.0, 1.0 - (n_iter - 1) / 100
    Y = mutate(NonUniformMutation(prob_var=1.0, b=b, form=form), X, n_iter=n_iter)
    ahead = np.where(Y > X, UPPER - X, X - LOWER)[:, 0]
    share = np.abs(Y - X)[:, 0] / ahead
    r = share / rest**b if form == "linear" else (1.0 - share) ** (1.0 / rest**b)
    assert stats.kstest(r, "uniform").pvalue > 0.01


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


def test_an_explicit_last_generation_overrides_the_termination(X):
    mutation = NonUniformMutation(prob_var=1.0, last_generation=20)
    assert np.array_equal(mutate(mutation, X, n_iter=21), X)
    assert not np.array_equal(mutate(mutation, X, n_iter=20), X)


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
    [{"form": "cubic"}, {"b": -1.0}, {"b": np.nan}, {"last_generation": 0}, {"prob_var": 1.5}, {"prob_var": -0.1}],
)
def test_settings_without_meaning_are_refused(setting):
    with pytest.raises(AlgorithmError, match=next(iter(setting))):
        NonUniformMutation(**setting)
