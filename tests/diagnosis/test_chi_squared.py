"""The distribution of chi-squared is the one that scipy has."""

import numpy as np
import pytest
from scipy.stats import chi2

from robolaser.diagnosis.chi_squared import median, survival


@pytest.mark.parametrize("freedoms", range(1, 9))
def test_survival_is_that_of_scipy(freedoms: int) -> None:
    values = np.array([0.0, 1e-9, 0.01, 0.5, 1.0, 3.0, 10.0, 40.0, 300.0, 1200.0])
    ours = [survival(value, freedoms) for value in values]
    np.testing.assert_allclose(ours, chi2.sf(values, freedoms), rtol=1e-12)


def test_survival_of_a_huge_or_a_negative_value_is_none_or_certain() -> None:
    assert survival(1e6, 5) == 0.0
    assert survival(-1e-12, 3) == 1.0


@pytest.mark.parametrize("freedoms", [1.0, 1.5, 2.0, 2.5, 3.0, 5.5, 40.0])
def test_median_is_that_of_scipy(freedoms: float) -> None:
    assert median(freedoms) == pytest.approx(chi2.median(freedoms), rel=1e-12)
