"""Student's t is the one that scipy has."""

import pytest
from scipy.stats import t

from robolaser.diagnosis.student_t import half_width


@pytest.mark.parametrize("freedoms", [1, 2, 3, 4, 5, 10, 59, 300, 2999])
@pytest.mark.parametrize("probability", [0.5, 0.95, 0.999])
def test_half_of_an_interval_is_that_of_scipy(probability: float, freedoms: int) -> None:
    assert half_width(probability, freedoms) == pytest.approx(t.ppf(0.5 + 0.5 * probability, freedoms), rel=1e-9)
