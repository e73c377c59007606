"""Finite differences agree with closed forms, also at bounds and beside poles."""

import numpy as np
import pytest

from robolaser.finite_differences import central_differences, differences, forward_differences

T = np.linspace(0.0, 3.0, 40)
LOWER, UPPER, SCALE = np.array([0.0, 0.0, -1.0]), np.array([5.0, 2.0, 1.0]), np.array([1.0, 2.0, 10.0])


def decay(x):
    return x[:, :1] * np.exp(-x[:, 1:2] * T) + x[:, 2:3]


def slopes_of(x):
    fading = np.exp(-x[1] * T)
    return np.stack([fading, -x[0] * T * fading, np.ones_like(T)])


def by_differences(function, *x, columns=(0, 1, 2)):
    return differences(function, np.array(x), 1e-5 * SCALE, np.array(columns), LOWER, UPPER)


def test_derivatives_agree_with_the_closed_form_also_at_bounds():
    x = [0.0, 2.0, 1.0], [5.0, 0.0, -1.0], [1.0, 1.0, 0.0]
    for at, J in zip(x, by_differences(decay, *x), strict=True):
        np.testing.assert_allclose(J, slopes_of(at), atol=1e-7)


def test_derivatives_come_from_the_side_without_a_pole():
    def walled(x):
        return np.where(x[:, :1] > 1.0, np.nan, decay(x))

    assert by_differences(walled, [1.0, 1.0, 0.0])[0] == pytest.approx(slopes_of([1.0, 1.0, 0.0]), abs=1e-4)


def test_between_two_poles_a_derivative_is_zero():
    def alone(x):
        return np.where(x[:, :1] == 1.0, decay(x), np.nan)

    assert np.all(by_differences(alone, [1.0, 1.0, 0.0])[0, 0] == 0.0)


def test_only_the_columns_asked_for_are_differentiated():
    both = by_differences(decay, [1.0, 1.0, 0.0], columns=(0, 2))
    assert both.shape == (1, 2, len(T))
    np.testing.assert_allclose(both[0], slopes_of([1.0, 1.0, 0.0])[[0, 2]], atol=1e-7)


def test_a_batch_is_never_larger_than_memory_should_bear(monkeypatch):
    whole = by_differences(decay, [1.0, 1.0, 0.0])
    monkeypatch.setattr("robolaser.finite_differences.BATCH", 3 * len(T))

    def watched(x):
        assert len(x) <= 3
        return decay(x)

    np.testing.assert_array_equal(by_differences(watched, [1.0, 1.0, 0.0]), whole)


def test_shifts_about_a_point_give_the_same_derivatives_one_sided_to_first_order():
    at = np.array([1.0, 1.0, 0.0])

    def shifted(shifts):
        return decay(at + shifts)

    np.testing.assert_allclose(central_differences(shifted, 1e-5 * SCALE), slopes_of(at).T, atol=1e-7)
    one_sided = forward_differences(shifted, 1e-5 * SCALE, shifted(np.zeros((1, 3)))[0])
    np.testing.assert_allclose(one_sided, slopes_of(at).T, atol=1e-4)
