"""Rows of a plain fit, and the fit by noise, where some points are gross errors."""

import numpy as np
import pytest

from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import as_json
from robolaser.data.stated_noise import Noise
from robolaser.estimation.plain_fit import size_of_errors
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


def test_weights_by_noise_leave_gross_errors_out_but_count_them_in_j():
    noise = Noise(pixel_px=0.1, target_m=3e-5)
    spoilt = simulate(find_robot("scorbot_er7"), poses=30, points=10, noise=noise, effects={"outliers": 0.05}, seed=2)
    plain, weighted = (
        calibrate(spoilt.dataset, Plan(algorithm="gauss-newton", weights=weights)) for weights in ("plain", "noise")
    )
    assert set(spoilt.gross) <= set(np.flatnonzero(weighted.weighted.outliers))
    assert any("are gross errors" in warning for warning in weighted.warnings)
    truth = np.array([spoilt.truth[name] for name in weighted.model.parameters.names])
    known = weighted.model.residuals(truth[None])
    off, far_off = (np.linalg.norm(one.model.residuals(one.x[None]) - known) for one in (weighted, plain))
    assert off < far_off / 3
    assert as_json(weighted)["objective_m2"] == pytest.approx((weighted.model.residuals(weighted.x[None]) ** 2).sum())
    assert plain.objective_m2 < weighted.objective_m2


@pytest.mark.parametrize("numbers", [1, 3])
def test_an_errors_size_is_found_however_many_numbers_a_row_has(numbers):
    rng = np.random.default_rng(20)
    directions = np.linalg.qr(rng.normal(size=(2000, 3, 3)))[0][:, :numbers]
    shaken = (directions @ (0.02 * rng.normal(size=(2000, 3, 1))))[..., 0]
    assert size_of_errors(directions, shaken) == pytest.approx(0.02, rel=0.35)
