"""Gross errors count for little where that is asked for, and are told of."""

import numpy as np
import pytest

from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import as_json
from robolaser.data.stated_noise import Noise
from robolaser.errors import UsageError
from robolaser.estimation.robust_reweighting import size_of_errors
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

NOISE = Noise(pixel_px=0.1, target_m=3e-5)


@pytest.fixture(scope="module")
def spoilt():
    return simulate(find_robot("scorbot_er7"), poses=30, points=10, noise=NOISE, effects={"outliers": 0.05}, seed=2)


@pytest.fixture(scope="module")
def found(spoilt):
    return {
        loss: calibrate(spoilt.dataset, Plan(algorithm="gauss-newton", loss=loss))
        for loss in ("square", "huber", "cauchy")
    }


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_points_of_a_spoilt_cell_are_predicted_as_if_it_were_not(spoilt, found, loss):
    model = Model(spoilt.dataset)
    truth = np.array([spoilt.truth[name] for name in model.parameters.names])
    kept = np.setdiff1d(np.arange(len(spoilt.dataset.points)), spoilt.gross)

    def off(x):
        apart = model.residuals(x[None])[0] - model.residuals(truth[None])[0]
        return np.sqrt((apart[kept] ** 2).sum(axis=-1).mean())

    assert off(found[loss].x) < 0.25 * off(found["square"].x)


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_a_warning_says_how_many_points_count_for_less_than_half(spoilt, found, loss):
    (said,) = [warning for warning in found[loss].warnings if "less than half" in warning]
    number = int(said.split()[0])
    assert 0.6 * len(spoilt.gross) <= number <= len(spoilt.gross) + 10
    assert not any("less than half" in warning for warning in found["square"].warnings)


def test_j_is_that_of_all_rows_whatever_was_minimised(found):
    for one in found.values():
        assert as_json(one)["objective_m2"] == pytest.approx((one.model.residuals(one.x[None]) ** 2).sum())
    assert found["square"].objective_m2 < min(found["huber"].objective_m2, found["cauchy"].objective_m2)


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_standard_errors_are_those_of_the_noise_not_of_the_gross_errors(found, loss):
    free = np.isfinite(found["square"].std) & np.isfinite(found[loss].std)
    assert np.median(found[loss].std[free] / found["square"].std[free]) < 0.7


def test_without_gross_errors_the_loss_hardly_matters():
    clean = simulate(find_robot("scorbot_er7"), poses=30, points=10, noise=NOISE, seed=2)
    plain, robust = (
        calibrate(clean.dataset, Plan(algorithm="gauss-newton", loss=loss)) for loss in ("square", "huber")
    )
    apart = np.abs(plain.x - robust.x)
    assert np.nanmax(apart / plain.std) < 1.0
    assert np.nanmedian(robust.std / plain.std) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("loss", ["square", "cauchy"])
def test_weights_by_noise_leave_gross_errors_out_whatever_the_loss(spoilt, found, loss):
    weighted = calibrate(spoilt.dataset, Plan(algorithm="gauss-newton", loss=loss, weights="noise"))
    assert set(spoilt.gross) <= set(np.flatnonzero(weighted.weighted.outliers))
    assert any("are gross errors" in warning for warning in weighted.warnings)
    truth = np.array([spoilt.truth[name] for name in weighted.model.parameters.names])
    known = weighted.model.residuals(truth[None])
    off, plain = (np.linalg.norm(one.model.residuals(one.x[None]) - known) for one in (weighted, found["square"]))
    assert off < plain / 3


def test_an_unknown_loss_is_refused(spoilt):
    with pytest.raises(UsageError):
        calibrate(spoilt.dataset, Plan(algorithm="gauss-newton", loss="l1"))


@pytest.mark.parametrize("numbers", [1, 3])
def test_an_errors_size_is_found_however_many_numbers_a_row_has(numbers):
    rng = np.random.default_rng(20)
    axes = rng.normal(size=(2000, 3, 3))
    directions = np.linalg.qr(axes)[0][:, :numbers]
    shaken = (directions @ (0.02 * rng.normal(size=(2000, 3, 1))))[..., 0]
    assert size_of_errors(directions, shaken) == pytest.approx(0.02, rel=0.35)
