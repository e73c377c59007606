"""The polish agrees with SciPy, keeps to the bounds and survives poles and gauge freedom."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from robolaser.errors import ResidualsShape
from robolaser.estimation.differences import Around
from robolaser.estimation.gauss_newton import gauss_newton

T = np.linspace(0.0, 3.0, 40)
NOISE = 0.01 * np.random.default_rng(5).standard_normal(40)
INF = np.inf
ROUNDING = 1e-6  # of residuals that vanish at the optimum: their direction means nothing


def rosenbrock(x):
    return np.stack([10.0 * (x[:, 1] - x[:, 0] ** 2), 1.0 - x[:, 0]], axis=1)


def decay(x):
    return x[:, :1] * np.exp(-x[:, 1:2] * T) + x[:, 2:3] - (2.0 * np.exp(-1.3 * T) + 0.5 + NOISE)


def wave(x):
    return x[:, :1] * np.sin(x[:, 1:2] * T + x[:, 2:3]) - (1.5 * np.sin(2.0 * T + 0.3) + NOISE)


def gauged_decay(x):
    """Only the product of the first two can be seen, and only the sum of the last two."""
    return decay(np.stack([x[:, 0] * x[:, 1], x[:, 2], x[:, 3] + x[:, 4]], axis=1))


def pole(x):
    with np.errstate(divide="ignore", invalid="ignore"):
        return x[:, :1] / (T + x[:, 1:2]) - (1.0 / (T + 0.4) + NOISE)


def circle(x):
    at = np.stack([np.cos(2 * T), np.sin(2 * T)])
    centre, radius = x[:, :2, None], x[:, 2:3]
    return np.hypot(*(np.moveaxis(at - centre, 1, 0))) - radius + NOISE


def beale(x):
    k = np.arange(1, 4)
    return np.array([1.5, 2.25, 2.625]) - x[:, :1] * (1.0 - x[:, 1:2] ** k)


CASES = {
    "rosenbrock": (rosenbrock, [-1.2, 1.0], [-INF, -INF], [INF, INF]),
    "rosenbrock bounded": (rosenbrock, [-1.2, 1.0], [-2.0, -2.0], [0.7, 2.0]),
    "rosenbrock in a corner": (rosenbrock, [-0.3, 1.8], [-2.0, 1.5], [0.5, 2.0]),
    "decay": (decay, [1.0, 1.0, 0.0], [0.0, 0.0, -1.0], [5.0, 5.0, 1.0]),
    "decay with an active bound": (decay, [1.0, 0.5, 0.0], [0.0, 0.0, -1.0], [5.0, 1.1, 1.0]),
    "decay with two active bounds": (decay, [1.0, 0.5, 0.0], [0.0, 0.0, -1.0], [1.9, 5.0, 0.3]),
    "decay from a bound": (decay, [1.0, 0.0, 1.0], [0.0, 0.0, -1.0], [5.0, 5.0, 1.0]),
    "wave": (wave, [1.0, 1.8, 0.0], [0.0, 0.5, -1.0], [3.0, 3.0, 1.0]),
    "wave, phase bounded": (wave, [1.0, 1.8, 0.0], [0.0, 0.5, -1.0], [3.0, 3.0, 0.1]),
    "gauged": (gauged_decay, [1.0, 1.0, 1.0, 0.0, 0.1], [0.1, 0.1, 0.0, -1.0, -1.0], [5.0, 5.0, 5.0, 1.0, 1.0]),
    "gauged, one on its bound": (
        gauged_decay,
        [1.0, 1.0, 1.0, 0.0, 0.1],
        [0.1, 0.1, 0.0, -1.0, -1.0],
        [1.2, 5.0, 1.2, 1.0, 0.15],
    ),
    "pole": (pole, [0.5, 1.0], [0.0, 0.01], [4.0, 3.0]),
    "circle": (circle, [0.3, -0.2, 0.5], [-1.0, -1.0, 0.1], [1.0, 1.0, 3.0]),
    "circle, centre bounded": (circle, [0.3, -0.2, 0.5], [0.1, -1.0, 0.1], [1.0, -0.05, 3.0]),
    "beale": (beale, [1.0, 0.5], [-4.5, -4.5], [4.5, 4.5]),
}


@pytest.fixture(params=CASES.values(), ids=CASES.keys())
def case(request):
    residuals, *rest = request.param
    return residuals, *(np.array(values, np.float64) for values in rest)


def scipy_cost(residuals, x0, lower, upper):
    found = least_squares(
        lambda x: residuals(x[None])[0],
        x0,
        bounds=(lower, upper),
        jac="3-point",
        method="trf",
        x_scale="jac",
        xtol=1e-15,
        ftol=1e-15,
        gtol=1e-15,
        max_nfev=5000,
    )
    return 2.0 * found.cost


def test_the_optimum_costs_no_more_than_scipys(case):
    residuals, x0, lower, upper = case
    ours = gauss_newton(residuals, x0, lower, upper)
    theirs = scipy_cost(residuals, x0, lower, upper)
    assert ours.converged
    assert ours.cost <= theirs * (1.0 + 1e-9) + 1e-25


def test_the_optimum_satisfies_the_conditions_of_karush_kuhn_and_tucker(case):
    residuals, x0, lower, upper = case
    found = gauss_newton(residuals, x0, lower, upper)
    *slopes, r = Around(found.x, lower, upper, np.ones(len(x0))).slopes(residuals, residuals(x0[None]).shape[1])
    gradient = slopes @ r / (np.linalg.norm(slopes, axis=1) * (np.linalg.norm(r) + ROUNDING))
    assert np.all((found.x >= lower) & (found.x <= upper))
    assert np.all(found.on_bound == ((found.x == lower) | (found.x == upper)))
    assert np.all(np.abs(gradient[~found.on_bound]) < 1e-5)
    assert np.all(gradient[found.x == lower] > -1e-5)
    assert np.all(gradient[found.x == upper] < 1e-5)


def test_candidates_never_leave_the_bounds(case):
    residuals, x0, lower, upper = case

    def watched(x):
        assert np.all((x >= lower) & (x <= upper))
        return residuals(x)

    gauss_newton(watched, x0, lower, upper)


def test_evaluations_are_counted_and_come_in_batches(case):
    residuals, x0, lower, upper = case
    batches = []

    def counted(x):
        batches.append(len(x))
        return residuals(x)

    found = gauss_newton(counted, x0, lower, upper)
    assert found.evaluations == sum(batches)
    assert len(batches) <= 3 * found.iterations + 12


def test_a_second_polish_changes_nothing(case):
    residuals, x0, lower, upper = case
    once = gauss_newton(residuals, x0, lower, upper)
    twice = gauss_newton(residuals, once.x, lower, upper)
    assert twice.cost <= once.cost
    assert twice.cost == pytest.approx(once.cost, rel=1e-9, abs=1e-25)


def test_steps_avoid_places_without_a_finite_residual():
    def walled(x):
        return np.where(x[:, :1] > 1.9, np.nan, decay(x))

    found = gauss_newton(walled, np.array([0.2, 3.0, 0.9]), np.zeros(3), np.full(3, 5.0))
    assert np.isfinite(found.cost)
    assert found.x[0] <= 1.9
    assert found.cost < np.sum(walled(np.array([[0.2, 3.0, 0.9]])) ** 2)


def test_a_start_without_a_finite_residual_is_handed_back():
    found = gauss_newton(lambda x: np.full((len(x), 3), np.nan), np.ones(2), np.zeros(2), np.full(2, 2.0))
    assert found.cost == np.inf
    assert not found.converged
    assert np.array_equal(found.x, np.ones(2))


def test_a_start_outside_is_brought_within_the_bounds():
    lower, upper = np.zeros(3), np.full(3, 5.0)
    found = gauss_newton(decay, np.array([9.0, -4.0, 0.2]), lower, upper)
    assert found.cost == pytest.approx(scipy_cost(decay, np.array([1.0, 1.0, 0.2]), lower, upper), rel=1e-9)


def test_gauge_freedom_is_left_where_it_started():
    lower, upper = np.full(5, -10.0), np.full(5, 10.0)
    found = gauss_newton(gauged_decay, np.array([1.0, 1.0, 1.0, 0.1, 0.1]), lower, upper)
    assert found.x[0] == pytest.approx(found.x[1])
    assert found.x[3] == pytest.approx(found.x[4])


def test_a_variable_without_room_stays():
    lower, upper = np.array([0.0, 1.0, -1.0]), np.array([5.0, 1.0, 1.0])
    found = gauss_newton(decay, np.array([1.0, 1.0, 0.0]), lower, upper)
    assert found.x[1] == 1.0
    assert not found.on_bound[1]
    assert found.converged


def test_more_variables_than_residuals_are_solved_exactly():
    found = gauss_newton(
        lambda x: np.sin(x.sum(axis=1, keepdims=True)) - 0.5, np.zeros(4), np.full(4, -1.0), np.ones(4)
    )
    assert found.cost < 1e-28
    assert found.x == pytest.approx(np.full(4, np.pi / 24))


def test_units_of_the_variables_do_not_matter():
    units = np.array([1e-6, 1e3, 1e-3])
    plain = gauss_newton(decay, np.array([1.0, 1.0, 0.0]), np.zeros(3), np.full(3, 5.0))
    other = gauss_newton(lambda x: decay(x / units), units * [1.0, 1.0, 0.0], np.zeros(3), 5.0 * units)
    assert other.x / units == pytest.approx(plain.x, rel=1e-8)


def test_residuals_in_blocks_have_the_same_optimum(case):
    residuals, x0, lower, upper = case
    k = residuals(x0[None]).shape[1]

    def block(rows):
        return lambda x: residuals(x)[:, rows]

    whole = gauss_newton(residuals, x0, lower, upper)
    parts = gauss_newton([block(rows) for rows in np.array_split(np.arange(k), min(k, 4))], x0, lower, upper)
    assert parts.cost == pytest.approx(whole.cost, rel=1e-9, abs=1e-25)
    assert parts.converged


def test_a_batch_is_never_larger_than_memory_should_bear(case, monkeypatch):
    residuals, x0, lower, upper = case
    k = residuals(x0[None]).shape[1]
    monkeypatch.setattr("robolaser.estimation.differences.BATCH", 3 * k)
    monkeypatch.setattr("robolaser.estimation.rows.BATCH", 3 * k)

    def watched(x):
        assert x.shape[0] <= 3
        return residuals(x)

    found = gauss_newton(watched, x0, lower, upper)
    assert found.cost == pytest.approx(gauss_newton(residuals, x0, lower, upper).cost, rel=1e-9, abs=1e-25)


def test_residuals_of_the_wrong_shape_are_refused():
    with pytest.raises(ResidualsShape, match="expected \\(1, k\\)"):
        gauss_newton(lambda x: np.zeros(7), np.ones(2), np.zeros(2), np.full(2, 2.0))
