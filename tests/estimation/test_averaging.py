"""Repeats are averaged, and nothing else is; gross errors are left out of a fit by noise."""

from dataclasses import replace

import numpy as np
import pytest
from several import together

from robolaser import Plan, calibrate
from robolaser.calibration.result import as_json
from robolaser.data.stated_noise import Noise
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.plain_fit import size_of_errors
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model, of_data
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate


def test_points_along_a_profile_are_no_repeats_because_a_tracker_beside_it_has_some() -> None:
    noise = Noise(point_m=3e-5)
    balls = simulate("ur5", kind="profile", poses=20, noise=noise, seed=1).dataset
    twice = CellOptions(repeats=2)
    shots = simulate("ur5", kind="point", poses=20, points=1, noise=noise, options=twice, seed=1).dataset
    pose, rng = shots.points.pose, np.random.default_rng(0)
    there = balls.flange()[pose, :3, :3] @ (0.05, 0.02, 0.1) + balls.flange()[pose, :3, 3]
    tracked = replace(shots.points, xyz=there + 3e-5 * rng.standard_normal(there.shape))
    both = together(balls, {"balls": (balls, balls.points), "tracker": (shots, tracked)})
    np.testing.assert_array_equal(AveragedData.of(both).shots, [1] * len(balls.points) + [2] * 20)
    assert calibrate(both, weights="noise").rms_m < 4e-5


@pytest.mark.parametrize(
    ("kind", "effect"),
    [
        ("point", "base_shift"),
        ("point", "joint_compliance:shoulder_lift_joint"),
        ("point", "thermal_drift:elbow_joint"),
        ("camera", "hand_eye_drift"),
        ("camera", "focus_breathing"),
        ("camera", "target_warp"),
        ("camera", "target_stretch"),
    ],
)
def test_rows_of_a_part_are_left_as_they_are_left_among_all(kind: str, effect: str) -> None:
    made = simulate("ur5", kind=kind, poses=330, points={"point": 1, "camera": 20}[kind], seed=1).dataset
    data = AveragedData.of(replace(made, path_known=False, time_is_order=True)).subsampled(1)
    assert len(data.dataset.poses) < len(made.poses)
    model = Model(data.raw, candidate_effects([effect], data.raw))
    sizes = [item.nominal + 0.1 * (item.upper - item.lower) for item in model.effect_parameters.items]
    x = np.append(model.sensor_parameters.nominal, sizes)[None]
    part = of_data(model, data.dataset).residuals(x)
    np.testing.assert_allclose(part, model.residuals(x)[:, data.group >= 0], atol=1e-9)


def test_weights_by_noise_leave_gross_errors_out_but_count_them_in_j():
    noise = Noise(pixel_px=0.1, target_m=3e-5)
    spoilt = simulate(find_robot("scorbot_er7"), poses=30, points=10, noise=noise, effects={"outliers": 0.05}, seed=2)
    plans = (Plan(algorithm="gauss-newton", weights=weights) for weights in ("plain", "noise"))
    plain, weighted = (calibrate(spoilt.dataset, plan).calibration for plan in plans)
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
