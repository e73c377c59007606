"""Derivatives agree with closed forms, also at bounds and beside poles; a triangle stands for all rows."""

import numpy as np
import pytest

from robolaser.estimation.differences import Around
from robolaser.estimation.r_factor import TALL, triangle

T = np.linspace(0.0, 3.0, 40)


def decay(x):
    return x[:, :1] * np.exp(-x[:, 1:2] * T) + x[:, 2:3]


def slopes_of(x):
    fading = np.exp(-x[1] * T)
    return np.stack([fading, -x[0] * T * fading, np.ones_like(T)])


@pytest.mark.parametrize("x", [[0.0, 2.0, 1.0], [5.0, 0.0, -1.0], [1.0, 1.0, 0.0]])
def test_derivatives_agree_with_the_closed_form_also_at_bounds(x):
    around = Around(np.array(x), np.array([0.0, 0.0, -1.0]), np.array([5.0, 2.0, 1.0]), np.array([1.0, 2.0, 10.0]))
    slopes = around.slopes(decay, len(T))
    np.testing.assert_allclose(slopes[:-1], slopes_of(around.x) * around.scale[:, None], atol=1e-7)
    assert np.array_equal(slopes[-1], decay(around.x[None])[0])


def test_derivatives_come_from_the_side_without_a_pole():
    def walled(x):
        return np.where(x[:, :1] > 1.0, np.nan, decay(x))

    around = Around(np.array([1.0, 1.0, 0.0]), np.zeros(3), np.full(3, 5.0), np.ones(3))
    assert around.slopes(walled, len(T))[:-1] == pytest.approx(slopes_of(around.x), abs=1e-4)


def test_between_two_poles_a_derivative_is_zero():
    def alone(x):
        return np.where(x[:, :1] == 1.0, decay(x), np.nan)

    around = Around(np.array([1.0, 1.0, 0.0]), np.zeros(3), np.full(3, 5.0), np.ones(3))
    assert np.all(around.slopes(alone, len(T))[0] == 0.0)


def test_a_variable_without_room_has_no_derivative():
    around = Around(np.array([1.0, 1.0, 0.0]), np.array([0.0, 1.0, -1.0]), np.array([5.0, 1.0, 1.0]), np.ones(3))
    assert np.all(around.slopes(decay, len(T))[1] == 0.0)


@pytest.mark.parametrize("rows", [1, 3, 4, TALL, 3 * TALL + 5])
def test_a_triangle_is_as_long_in_every_direction_as_all_the_rows(rows):
    rng = np.random.default_rng(rows)
    A, p = rng.normal(size=(rows, 4)) * 10.0 ** np.arange(-6, 6, 3), rng.normal(size=(4, 50))
    A[:, 2] += A[:, 1]
    R = triangle(A[rows // 2 :], triangle(A[: rows // 2]))
    assert len(R) == min(rows, 4)
    p = p / 10.0 ** np.arange(-6, 6, 3)[:, None]
    np.testing.assert_allclose(np.linalg.norm(R @ p, axis=0), np.linalg.norm(A @ p, axis=0), rtol=1e-12)
