"""The solver agrees with SciPy, keeps to the bounds and survives poles and gauge freedom."""

import numpy as np
import pytest
from functions import FunctionProblem
from scipy.optimize import least_squares

from robolaser.estimation.solver import solve

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
        lambda x: residuals(x[None])[0], x0, bounds=(lower, upper), jac="3-point", method="trf", x_scale="jac",
        xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=5000,
    )  # fmt: skip
    return 2.0 * found.cost


def test_the_optimum_costs_no_more_than_scipys(case):
    residuals, x0, lower, upper = case
    ours = solve(FunctionProblem(residuals, x0, lower, upper), x0[None])
    theirs = scipy_cost(residuals, x0, lower, upper)
    assert ours.converged[0]
    assert ours.cost[0] <= theirs * (1.0 + 1e-9) + 1e-25


def test_the_optimum_satisfies_the_conditions_of_karush_kuhn_and_tucker(case):
    residuals, x0, lower, upper = case
    problem = FunctionProblem(residuals, x0, lower, upper)
    x = solve(problem, x0[None]).x
    slopes, r = problem.jacobian(x)[0], residuals(x)[0]
    gradient = slopes @ r / (np.linalg.norm(slopes, axis=1) * (np.linalg.norm(r) + ROUNDING))
    at_lower, at_upper = x[0] == lower, x[0] == upper
    assert np.all((x[0] >= lower) & (x[0] <= upper))
    assert np.all(np.abs(gradient[~at_lower & ~at_upper]) < 1e-5)
    assert np.all(gradient[at_lower] > -1e-5)
    assert np.all(gradient[at_upper] < 1e-5)


def test_candidates_never_leave_the_bounds(case):
    residuals, x0, lower, upper = case

    def watched(x):
        assert np.all((x >= lower) & (x <= upper))
        return residuals(x)

    solve(FunctionProblem(watched, x0, lower, upper), x0[None])


def test_a_candidate_ends_where_it_would_alone_whoever_descends_beside_it(case):
    residuals, x0, lower, upper = case
    problem = FunctionProblem(residuals, x0, lower, upper)
    reach = np.where(np.isfinite(upper - lower), upper - lower, 1.0)
    starts = np.clip(x0 + 0.1 * reach * np.random.default_rng(1).normal(size=(5, len(x0))), lower, upper)
    together = solve(problem, starts)
    for start, cost in zip(starts, together.cost, strict=True):
        assert solve(problem, start[None]).cost[0] == pytest.approx(cost, rel=1e-9, abs=1e-25)


def test_rows_that_are_left_out_do_not_count(case):
    residuals, x0, lower, upper = case
    problem = FunctionProblem(residuals, x0, lower, upper)
    kept = np.ones((2, problem.rows), dtype=bool)
    kept[1, ::3] = False
    both = solve(problem, np.stack([x0, x0]), kept=kept)
    fewer = FunctionProblem(lambda x: residuals(x)[:, kept[1]], x0, lower, upper)
    assert both.cost[0] == pytest.approx(solve(problem, x0[None]).cost[0], rel=1e-9, abs=1e-25)
    assert both.cost[1] == pytest.approx(solve(fewer, x0[None]).cost[0], rel=1e-8, abs=1e-25)


def test_a_second_fit_changes_nothing(case):
    residuals, x0, lower, upper = case
    problem = FunctionProblem(residuals, x0, lower, upper)
    once = solve(problem, x0[None])
    twice = solve(problem, once.x)
    assert twice.cost[0] <= once.cost[0]
    assert twice.cost[0] == pytest.approx(once.cost[0], rel=1e-9, abs=1e-25)


def end(residuals, x0, lower, upper):
    return solve(FunctionProblem(residuals, np.asarray(x0), lower, upper), np.asarray(x0)[None])


def test_steps_avoid_places_without_a_finite_residual():
    def walled(x):
        return np.where(x[:, :1] > 1.9, np.nan, decay(x))

    found = end(walled, np.array([0.2, 3.0, 0.9]), np.zeros(3), np.full(3, 5.0))
    assert np.isfinite(found.cost[0])
    assert found.x[0, 0] <= 1.9
    assert found.cost[0] < np.sum(walled(np.array([[0.2, 3.0, 0.9]])) ** 2)


def test_a_start_without_a_finite_residual_is_handed_back():
    found = end(lambda x: np.full((len(x), 3), np.nan), np.ones(2), np.zeros(2), np.full(2, 2.0))
    assert found.cost[0] == np.inf
    assert not found.converged[0]
    assert np.array_equal(found.x[0], np.ones(2))


def test_a_start_outside_is_brought_within_the_bounds():
    lower, upper = np.zeros(3), np.full(3, 5.0)
    found = end(decay, np.array([9.0, -4.0, 0.2]), lower, upper)
    assert found.cost[0] == pytest.approx(scipy_cost(decay, np.array([1.0, 1.0, 0.2]), lower, upper), rel=1e-9)


def test_gauge_freedom_is_left_where_it_started():
    lower, upper = np.full(5, -10.0), np.full(5, 10.0)
    found = end(gauged_decay, np.array([1.0, 1.0, 1.0, 0.1, 0.1]), lower, upper)
    assert found.x[0, 0] == pytest.approx(found.x[0, 1], rel=1e-3)
    assert found.x[0, 3] == pytest.approx(found.x[0, 4], rel=1e-3)


def test_a_fixed_parameter_stays():
    lower, upper = np.array([0.0, 1.0, -1.0]), np.array([5.0, 1.0, 1.0])
    found = end(decay, np.array([1.0, 1.0, 0.0]), lower, upper)
    assert found.x[0, 1] == 1.0
    assert found.converged[0]


def test_more_parameters_than_residuals_are_solved_exactly():
    found = end(lambda x: np.sin(x.sum(axis=1, keepdims=True)) - 0.5, np.zeros(4), np.full(4, -1.0), np.ones(4))
    assert found.cost[0] < 1e-24
    assert found.x[0] == pytest.approx(np.full(4, np.pi / 24))


def test_units_of_the_parameters_do_not_matter():
    units = np.array([1e-6, 1e3, 1e-3])
    plain = end(decay, np.array([1.0, 1.0, 0.0]), np.zeros(3), np.full(3, 5.0))
    other = end(lambda x: decay(x / units), units * [1.0, 1.0, 0.0], np.zeros(3), 5.0 * units)
    assert other.x[0] / units == pytest.approx(plain.x[0], rel=1e-7)


def test_no_candidates_have_no_end():
    problem = FunctionProblem(decay, np.ones(3), np.zeros(3), np.full(3, 5.0))
    assert solve(problem, np.empty((0, 3))).x.shape == (0, 3)


def test_derivatives_from_elsewhere_change_no_optimum(case):
    residuals, x0, lower, upper = case
    problem = FunctionProblem(residuals, x0, lower, upper)
    elsewhere = problem.jacobian(np.clip(x0 + 0.05, lower, upper)[None])[0]
    alone = solve(problem, x0[None]).cost[0]
    assert solve(problem, x0[None], slopes=elsewhere).cost[0] == pytest.approx(alone, rel=1e-9, abs=1e-20)


def test_the_loss_against_a_rival_is_known_to_a_hundredth(case):
    residuals, x0, lower, upper = case
    problem = FunctionProblem(residuals, x0, lower, upper)
    optimum = solve(problem, x0[None]).cost[0]
    assert solve(problem, x0[None], rival=0.5 * optimum).cost[0] <= (1.0 + 1e-2) * optimum + 1e-20
