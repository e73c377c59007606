"""An R factor stands for all rows."""

import numpy as np
import pytest

from robolaser.estimation.r_factor import TALL, triangle


@pytest.mark.parametrize("rows", [1, 3, 4, TALL, 3 * TALL + 5])
def test_an_r_factor_is_as_long_in_every_direction_as_all_the_rows(rows):
    rng = np.random.default_rng(rows)
    A, p = rng.normal(size=(rows, 4)) * 10.0 ** np.arange(-6, 6, 3), rng.normal(size=(4, 50))
    A[:, 2] += A[:, 1]
    R = triangle(A[rows // 2 :], triangle(A[: rows // 2]))
    assert len(R) == min(rows, 4)
    p = p / 10.0 ** np.arange(-6, 6, 3)[:, None]
    np.testing.assert_allclose(np.linalg.norm(R @ p, axis=0), np.linalg.norm(A @ p, axis=0), rtol=1e-12)
