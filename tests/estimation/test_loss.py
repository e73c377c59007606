"""The robust loss: the minimum is SciPy's, and rows count for what it says."""

import numpy as np
import pytest
from functions import FunctionProblem
from scipy.optimize import least_squares, minimize

from robolaser.estimation.outliers import MEDIAN, TAIL
from robolaser.estimation.robust_loss import Loss
from robolaser.estimation.solver import solve

TRUTH = np.array([0.3, -0.2, 0.5, 0.4, -0.3, 0.2])
LOWER, UPPER = np.full(6, -2.0), np.full(6, 2.0)
STARTS = np.arange(0, 120, 3)


def fitted(residuals, loss):
    return solve(FunctionProblem(residuals, np.zeros(6), LOWER, UPPER, loss, axes=3), np.zeros((1, 6)))


@pytest.fixture(params=range(3))
def residuals(request):
    """Points turned a little and shifted, a tenth of them far off: (c, 6) -> (c, 3m)."""
    rng = np.random.default_rng(request.param)
    P = rng.uniform(-1, 1, (40, 3))

    def moved(x):
        turned = P + np.cross(x[:, None, :3], P) + 0.5 * np.cross(x[:, None, :3], np.cross(x[:, None, :3], P))
        return turned + x[:, None, 3:]

    seen = moved(TRUTH[None])[0] + 0.01 * rng.normal(size=P.shape)
    seen[:4] += rng.normal(size=(4, 3))
    return lambda x: (moved(x) - seen).reshape(len(x), -1)


@pytest.mark.parametrize("scale", [0.005, 0.02, 0.5])
def test_the_optimum_is_that_of_a_plain_minimisation(residuals, scale):
    loss = Loss(scale)
    ours = fitted(residuals, loss)
    theirs = minimize(
        lambda x: loss.costs(residuals(x[None]), STARTS)[0] / scale**2, ours.x[0] + 1e-3, method="BFGS", tol=1e-10
    )
    assert ours.converged[0]
    assert ours.cost[0] <= theirs.fun * scale**2 * (1 + 1e-9)
    assert ours.x[0] == pytest.approx(theirs.x, abs=1e-5)


def test_costs_are_scipys():
    x = np.random.default_rng(1).normal(size=9) * 3.0
    rows = np.zeros((1, 9, 3))
    rows[0, :, 1] = x
    theirs = least_squares(lambda t: x, [0.0], loss="cauchy", f_scale=0.7, max_nfev=1)
    assert Loss(0.7).costs(rows.reshape(1, -1), np.arange(0, 27, 3))[0] == pytest.approx(2.0 * theirs.cost)


@pytest.mark.parametrize("scale", [0.02, np.inf])
def test_linearized_squares_have_the_slope_of_the_cost(residuals, scale):
    loss = Loss(scale)
    x = TRUTH + 0.01
    J = FunctionProblem(residuals, x, LOWER, UPPER, loss, axes=3).jacobian(x[None]) / (UPPER - LOWER)[:, None]
    r, J = loss.linearized(residuals(x[None]), J, STARTS)
    step = 1e-6 * np.eye(6)
    rise = (loss.costs(residuals(x + step), STARTS) - loss.costs(residuals(x - step), STARTS)) / 2e-6
    np.testing.assert_allclose(2.0 * J[0] @ r[0], rise, rtol=1e-4, atol=1e-6)


def test_rows_may_have_different_numbers():
    e, starts = np.array([[3.0, 4.0, 0.1, 12.0, 5.0, 0.0]]), np.array([0, 2, 3])
    z = np.array([25.0, 0.01, 169.0])
    assert Loss(1.0).costs(e, starts)[0] == pytest.approx(np.log1p(z).sum())
    np.testing.assert_allclose(Loss(1.0).weights(e, starts)[0], 1.0 / (1.0 + z))


def test_small_residuals_cost_their_squares():
    rows = 1e-4 * np.random.default_rng(2).normal(size=(2, 30))
    starts = np.arange(0, 30, 3)
    assert Loss(1.0).costs(rows, starts) == pytest.approx(Loss().costs(rows, starts), rel=1e-6)
    assert Loss(1.0).weights(rows, starts) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("axes", [1, 3])
def test_of_normal_errors_no_more_than_a_twentieth_of_the_efficiency_is_lost(axes):
    """A mean of points is estimated, by weights: slow, but another way than the solver."""
    rng = np.random.default_rng(3)
    plain, robust, starts = [], [], np.arange(0, 180, 3)
    for _ in range(1500):
        e = rng.normal(size=(60, 3)) * (np.arange(3) < axes)
        loss = Loss(TAIL * np.median(np.linalg.norm(e, axis=1)) / MEDIAN)
        centre = e.mean(axis=0)
        for _ in range(25):
            share = loss.weights((e - centre).reshape(1, -1), starts)[0]
            centre = (share[:, None] * e).sum(axis=0) / share.sum()
        plain.append(e.mean(axis=0))
        robust.append(centre)
    assert 0.925 < np.sum(np.square(plain)) / np.sum(np.square(robust)) < 1.01
