"""Children of arithmetic crossover lie on the line between their parents."""

import numpy as np
import pytest
from bowl import LOWER, UPPER, running
from pymoo.core.population import Population
from scipy import stats

from robolaser.errors import AlgorithmError
from robolaser.operators import ArithmeticCrossover
from robolaser.operators.arithmetic_crossover import arithmetic


@pytest.fixture
def parents():
    return np.random.default_rng(1).uniform(LOWER, UPPER, (2, 3000, 5))


def cross(problem, parents, prob, seed=2):
    X = parents.swapaxes(0, 1).reshape(-1, 5)
    mates = np.arange(len(X)).reshape(-1, 2)
    children = ArithmeticCrossover(prob=prob).do(
        problem, Population.new(X=X), mates, random_state=np.random.default_rng(seed), algorithm=running(1)
    )
    return children.get("X").reshape(2, -1, 5)


@pytest.mark.parametrize("prob", [1.5, -1, np.nan])
def test_what_is_no_probability_is_refused(prob):
    with pytest.raises(AlgorithmError, match=r"ArithmeticCrossover: prob is .* expected a number from 0 to 1"):
        ArithmeticCrossover(prob=prob)


def test_shares_of_one_and_none_return_the_parents(parents):
    a, b = parents
    assert np.array_equal(arithmetic(np.stack([a, b]), np.ones((3000, 1))), (a, b))
    assert np.array_equal(arithmetic(np.stack([a, b]), np.zeros((3000, 1))), (b, a))


def test_the_sum_of_the_parents_is_kept(parents):
    a, b = parents
    c, d = arithmetic(np.stack([a, b]), np.random.default_rng(3).random((3000, 1)))
    np.testing.assert_allclose(c + d, a + b, rtol=1e-15, atol=1e-15 * (UPPER - LOWER).max())


def test_children_lie_between_their_parents_to_the_last_digit():
    rng = np.random.default_rng(4)
    a = rng.standard_normal((10_000, 3))
    b = np.where(rng.random(a.shape) < 0.5, a, np.nextafter(a, np.inf))
    for child in arithmetic(np.stack([a, b]), rng.random((10_000, 1))):
        assert np.all((child >= a) & (child <= b))


def test_one_share_serves_all_variables_of_a_pair_and_is_uniform(problem, parents):
    a, b = parents
    free = [0, 1, 2, 4]
    share = (cross(problem, parents, prob=1.0)[0] - b)[:, free] / (a - b)[:, free]
    np.testing.assert_allclose(share, np.broadcast_to(np.median(share, axis=1)[:, None], share.shape), atol=1e-3)
    assert stats.kstest(np.median(share, axis=1), "uniform").pvalue > 0.01


def test_without_probability_parents_pass_unchanged(problem, parents):
    assert np.array_equal(cross(problem, parents, prob=0.0), parents)


def test_as_many_pairs_are_crossed_as_the_probability_says(problem, parents):
    crossed = np.any(cross(problem, parents, prob=0.85) != parents, axis=(0, 2)).sum()
    assert stats.binomtest(int(crossed), 3000, 0.85).pvalue > 0.01
