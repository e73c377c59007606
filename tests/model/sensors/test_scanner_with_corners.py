"""A stripe scanner whose images show a board: one camera, seen twice."""

from dataclasses import replace

import numpy as np
import pytest
from asked import simulate_as_asked
from differences import central_differences

from robolaser import find_robot
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import Calibration, as_json
from robolaser.data.dataset import Dataset
from robolaser.data.several_sensors import with_points_of
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.pipeline import examine
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import exp_so3, from_quaternion, to_quaternion
from robolaser.model.blocks.errors import row_errors
from robolaser.model.blocks.start import initialize
from robolaser.model.effects import EFFECTS
from robolaser.model.forward_model import Model
from robolaser.model.stages import Perturbation
from robolaser.simulation import CellOptions, Simulated, simulate


def scanner(**options: object) -> Simulated:
    """On a UR10, its target somewhere."""
    return simulate_as_asked(find_robot("ur10"), kind="stripe+camera", poses=15, placed=False, seed=1, **options)


def with_nothing_given(dataset: Dataset) -> Dataset:
    return replace(dataset, parameters={})


@pytest.fixture(scope="module")
def noisy() -> Simulated:
    return scanner(noise=Noise(pixel_px=0.1))


@pytest.fixture(scope="module")
def found(noisy: Simulated) -> Calibration:
    return calibrate(noisy.dataset)


@pytest.fixture(scope="module")
def from_nothing(noisy: Simulated) -> Calibration:
    """Without any parameter given."""
    return calibrate(with_nothing_given(noisy.dataset))


@pytest.mark.parametrize("axis", ["u", "v"])
@pytest.mark.parametrize("effects", [{}, {"laser_roll": 0.1, "tangential_distortion": 0.3, "hand_eye_drift": 0.002}])
def test_the_truth_leaves_nothing(axis: str, effects: dict[str, float]) -> None:
    made = scanner(stripe_axis=axis, effects=effects)
    model = Model(made.dataset, made.effects)
    left = model.residuals_at({name: np.array([value]) for name, value in made.truth.items()})
    assert np.abs(left).max() < 1e-10


@pytest.mark.parametrize("effect", ["radial_distortion", "tangential_distortion"])
def test_a_lens_moves_corners_as_it_moves_the_stripe(effect: str) -> None:
    made = scanner(effects={effect: 0.3})
    model = Model(made.dataset)
    left = np.abs(model.residuals_at({name: np.array([made.truth[name]]) for name in model.parameters.names})[0])
    assert all(left[made.dataset.points.sensor == number].max() > 0.0 for number in (0, 1))


def test_with_sessions_nothing_needs_to_be_given_either() -> None:
    found = calibrate(with_nothing_given(scanner(sessions=2).dataset))
    assert found.rms_m < 1e-6
    assert {"target.x@session-1", "target.x@session-2", "theta"} <= set(found.model.parameters.names)


def test_in_a_session_the_camera_alone_may_see_the_board() -> None:
    """The few corners of a pose that are searched on do not place it."""
    dataset = scanner(sessions=2).dataset
    kept = (dataset.sensor_of_row == 1) | (dataset.session_of_pose[dataset.points.pose] == 0)
    found = calibrate(replace(dataset, points=dataset.points.take(np.flatnonzero(kept))))
    assert found.rms_m < 1e-6
    assert {"target.x@session-1", "target.x@session-2", "theta"} <= set(found.model.parameters.names)


def test_where_the_target_is_known_nothing_needs_to_be_given_either() -> None:
    placed = simulate(find_robot("panda"), kind="stripe+camera", poses=16, seed=2).dataset
    assert calibrate(with_nothing_given(placed)).rms_m < 1e-6


def test_both_have_the_parameters_of_one_camera(noisy: Simulated) -> None:
    assert set(Model(noisy.dataset).parameters.names) == set(noisy.truth)


@pytest.mark.parametrize("axis", ["u", "v"])
def test_a_corner_that_is_off_moves_its_pixel_as_the_stated_noise_of_the_target_does(axis: str) -> None:
    made = scanner(stripe_axis=axis, noise=Noise(target_m=3e-5))
    model = Model(made.dataset)
    values = {name: np.array([made.truth[name]]) for name in model.parameters.names}
    sources = {one.name: one for one in row_errors(model.blocks, values, model.flange(values), model.perturb(values))}
    noise = sources["camera.target"]
    assert noise.stated == 3e-5

    corners, xyz = made.dataset.points.sensor == 1, made.dataset.points["xyz"]

    def residuals(shift: np.ndarray) -> np.ndarray:
        moved = replace(made.dataset, points=replace(made.dataset.points, xyz=xyz + corners[:, None] * shift))
        return Model(moved).residuals_at(values)[0, corners, :2]

    by_shift = central_differences(lambda shifts: np.stack([residuals(one) for one in shifts]), np.full(3, 1e-6))
    A = noise.effect[corners, :2]
    covariance, expected = A @ np.swapaxes(A, 1, 2), by_shift @ np.swapaxes(by_shift, 1, 2)
    assert covariance == pytest.approx(expected, rel=1e-5, abs=1e-7 * expected.max())
    assert not noise.effect[~corners].any()


def test_with_nothing_given_it_ends_where_it_ends_with_bounds(found: Calibration, from_nothing: Calibration) -> None:
    assert from_nothing.rms_m == pytest.approx(found.rms_m, rel=1e-6)
    for name in ("b", "theta", "u_0", "v_0", "t_x", "phi"):
        assert from_nothing.value(name) == pytest.approx(found.value(name), rel=1e-4, abs=1e-6)


def test_the_result_says_where_each_parameter_started(found: Calibration, from_nothing: Calibration) -> None:
    started = as_json(from_nothing)["parameters"]
    assert started["s_u"]["started_from"] == "the board's corners"
    assert started["theta"]["started_from"] == "the stripe on the target"
    assert "started_from" not in as_json(found)["parameters"]["s_u"]


@pytest.mark.parametrize("angles", ["xyz", "zyz"])
def test_a_bracket_that_is_far_off_is_found(noisy: Simulated, found: Calibration, angles: str) -> None:
    turned = from_quaternion(np.array(noisy.dataset.bracket_quat)) @ exp_so3(
        np.deg2rad(171.0) * np.array([0.6, 0.0, 0.8])
    )
    bracket = tuple(to_quaternion(turned).tolist())
    members = tuple(
        replace(one, data=replace(one.data, bracket_quat=bracket, angles=angles)) for one in noisy.dataset.members
    )
    wrong = replace(with_nothing_given(noisy.dataset), members=members, bracket_quat=bracket, angles=angles)
    assert calibrate(wrong).rms_m == pytest.approx(found.rms_m, rel=1e-6)


def test_a_search_needs_bounds(noisy: Simulated) -> None:
    with pytest.raises(UsageError, match=r"searches within bounds, but dataset\.toml gives none for f, s_u"):
        calibrate(with_nothing_given(noisy.dataset), Plan(algorithm="rcga"))


def test_a_stripe_without_corners_must_be_told_its_scanner(noisy: Simulated) -> None:
    alone = noisy.dataset.sensors[0].data
    with pytest.raises(DataError, match=r"lacks f, s_u.*board's corners as a second sensor"):
        Model(alone).parameters  # noqa: B018 - asked for what it raises


def test_corners_tell_the_camera_better(noisy: Simulated, found: Calibration) -> None:
    alone = calibrate(replace(noisy.dataset.sensors[0].data, parameters=noisy.dataset.parameters))
    std = [one.std[one.model.parameters.names.index("v_0")] for one in (found, alone)]
    assert std[0] < 0.5 * std[1]


def test_units_stay_those_of_each_sensor(found: Calibration) -> None:
    rows = as_json(found)["rows"]
    assert [(row["sensor"], row["unit"]) for row in rows] == [("stripe", "m"), ("camera", "px")]
    assert rows[1]["rms"] == pytest.approx(0.1 * np.sqrt(2.0), rel=0.1)


FEW = [one for one in EFFECTS if one.name in ("joint_offset", "link_geometry", "laser_roll", "laser_curvature")]


@pytest.mark.parametrize(
    ("effects", "cause"), [({"joint_offset:joint_3": 0.003}, "arm_geometry"), ({"laser_roll": 0.03}, "laser")]
)
def test_an_arm_that_is_off_is_told_from_a_laser_that_is_off(effects: dict[str, float], cause: str) -> None:
    made = simulate(
        find_robot("scorbot_er7"), kind="stripe+camera", poses=16, options=CellOptions(placed=False), seed=2,
        noise=Noise(pixel_px=0.1), effects=effects,
    )  # fmt: skip
    found = examine(made.dataset, FEW, seed=0)
    assert found.verdict == "explained"
    assert [(one.name, one.probability > 0.9) for one in found.classes] == [(cause, True)]
    assert found.gap.after_m == pytest.approx(found.gap.noise_floor_m, rel=0.1)


def test_where_too_few_corners_are_seen_to_tell_the_target_the_stripe_does(noisy: Simulated) -> None:
    """As in a sample of the rows: of a pose two corners, in more poses than show the stripe."""
    points = noisy.dataset.points
    group = 2 * points.pose + points.sensor
    place = np.array([np.sum(group[:i] == number) for i, number in enumerate(group)])
    stripe = points.take((points.sensor == 0) & (points.pose > 0) & (place < 2))
    corners = points.take((points.sensor == 1) & (place < 2))
    model = Model(with_points_of(noisy.dataset, [replace(one, sensor=None) for one in (stripe, corners)]))
    values = {name: np.array([value]) for name, value in noisy.truth.items() if not name.startswith("target.")}
    found = initialize(model.blocks, values, model.dataset.flange()[None], Perturbation())
    assert found["target.x"][0] == pytest.approx(noisy.truth["target.x"], abs=2e-3)
