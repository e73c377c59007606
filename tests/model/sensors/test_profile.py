"""Profiles on balls: where sensor and balls are with nothing given, as exactly as the noise allows."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from asked import simulate_as_asked

import robolaser
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import as_json
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.diagnosis import examine
from robolaser.errors import DataError, EstimationError
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.export.ros import static_transform
from robolaser.geometry.rigid_motion import inverse
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model, jacobian
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.sensors.placements import motion
from robolaser.model.sensors.profile import circles
from robolaser.robot.by_name import find_robot
from robolaser.simulation import Simulated

POINT_M = 2e-5


def cell(robot: str = "ur5", **more: object) -> Simulated:
    noise = Noise(point_m=POINT_M)
    return simulate_as_asked(
        find_robot(robot), kind="profile", **{"noise": noise, "poses": 14, "points": 2, "seed": 1, **more}
    )


def test_a_circle_is_found_from_an_arc_of_it() -> None:
    rng = np.random.default_rng(0)
    centre, radius = rng.normal(size=(3, 2)), np.array([0.01, 0.02, 0.5])
    angle = rng.uniform(-1.0, 1.0, (3, 9))
    points = centre[:, None] + radius[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    found, radii, enough = circles(points.reshape(-1, 2), np.repeat(np.arange(3), 9))
    np.testing.assert_allclose(found, centre, atol=1e-10)
    np.testing.assert_allclose(radii, radius, atol=1e-10)
    assert enough.all()


@pytest.mark.parametrize("mount", ["flange", "base"])
@pytest.mark.parametrize("balls", [1, 3])
def test_wherever_sensor_and_balls_are_they_are_found_with_nothing_given(mount: str, balls: int) -> None:
    for seed, robot in enumerate(("ur5", "scorbot_er7", "panda")):
        made = cell(robot, mount=mount, points=balls, poses=16, seed=seed)
        model = Model(made.dataset)
        end = solve(Problem.of(model), model.parameters.nominal[None]).x
        truth = {name: np.array([value]) for name, value in made.truth.items()}
        apart = inverse(motion(truth, "hand_eye")) @ motion(model.parameters.values(end), "hand_eye")
        np.testing.assert_allclose(apart[0], np.eye(4), atol=3e-3)
        assert np.sqrt(np.mean(model.residuals(end) ** 2)) == pytest.approx(0.9 * POINT_M, rel=0.15)


def test_the_fit_weighed_by_noise_reaches_the_bound_of_cramer_and_rao() -> None:
    exact = cell(noise=None, poses=16)
    model = Model(replace(exact.dataset, noise=Noise(point_m=POINT_M)))
    truth = np.array([exact.truth[name] for name in model.parameters.names])
    values = model.parameters.values(truth[None])
    sources = tuple(model.blocks.sensor.row_errors(values, model.flange(values), model.perturb(values)))
    noise = NoiseModel(sources, {"point": POINT_M})
    J = noise.whiten(jacobian(model, truth[None])[0])
    bound = np.linalg.inv(J @ J.T)
    rng, seen = np.random.default_rng(0), exact.dataset.points
    missed = []
    for _ in range(20):
        profile = seen["profile"] + POINT_M * rng.normal(size=seen["profile"].shape)
        shaken = Model(replace(model.dataset, points=replace(seen, columns={"profile": profile})))
        missed.append(solve(Problem.of(shaken, noise, parameters=model.parameters), truth[None]).x[0] - truth)
    squares = np.einsum("ni,ij,nj->n", missed, np.linalg.inv(bound), missed) / len(truth)
    assert squares.mean() == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / len(truth) / len(missed)))
    bias = np.mean(missed, axis=0) * np.sqrt(len(missed)) / np.sqrt(np.diag(bound))
    assert np.abs(bias).max() < 4.0


def test_the_commands_fit_states_these_errors() -> None:
    made = cell(poses=16)
    found = calibrate(made.dataset, Plan(weights="noise"))
    z = (found.x - [made.truth[name] for name in found.model.parameters.names]) / found.std
    assert np.sqrt(np.mean(z**2)) < 2.0
    (rows,) = as_json(found)["rows"]
    assert (rows["sensor"], rows["rows"], rows["unit"]) == ("profile", 16 * 24, "m")
    assert rows["rms"] < rows["held_out_rms"] < 1.3 * rows["rms"]
    assert as_json(found)["parameters"]["hand_eye.x"]["nominal"] is None
    assert as_json(found)["model"]["mount"] == "flange"


def test_a_profile_cut_near_the_balls_rim_says_more() -> None:
    made = cell()
    model = Model(made.dataset)
    values = {name: np.array([value]) for name, value in made.truth.items()}
    (source,) = model.blocks.sensor.row_errors(values, model.flange(values), model.perturb(values))
    share = np.linalg.norm(source.effect[:, 0], axis=-1)
    assert share.max() <= 1.0 + 1e-12
    assert share.min() < 0.9


def test_known_distances_between_balls_are_rows_of_the_fit() -> None:
    made = cell(effects={"tracker_scale": 1e-3}, poses=20)
    balls = [np.array([made.truth[f"ball.{ball}.{part}"] for part in "xyz"]) for ball in "01"]
    known = replace(made.dataset, distances_m=(("0", "1", float(np.linalg.norm(balls[1] - balls[0]))),))
    found = calibrate(known, Plan(effects=("tracker_scale",), weights="noise"))
    assert [row["sensor"] for row in as_json(found)["rows"]] == ["profile", "distances"]
    scale = found.model.parameters.names.index("tracker_scale.measuring_system.scale")
    assert found.x[scale] == pytest.approx(1e-3, abs=4 * found.std[scale])


def test_a_flange_that_keeps_its_orientation_is_refused_in_a_sentence() -> None:
    made = cell().dataset
    T = made.flange()
    T[:, :3, :3] = T[0, :3, :3]
    fixed = replace(made, robot=None, poses=replace(made.poses, q=None, T_base_flange=T))
    with pytest.raises(EstimationError, match="turn the flange about two axes"):
        calibrate(fixed)


@pytest.mark.parametrize(("balls", "named"), [([0], "ball 0 "), ([1], "ball 1 "), ([0, 1], "ball 0, 1 ")])
def test_a_ball_whose_profiles_are_too_short_for_a_circle_is_named(balls: list[int], named: str) -> None:
    made = cell().dataset
    before = np.r_[True, (np.diff(made.points.pose) != 0) | (np.diff(made.points.number) != 0)]
    short = replace(made, points=made.points.take(before | ~np.isin(made.points.number, balls)))
    with pytest.raises(EstimationError, match=f"No profile of {named}has 3 points"):
        calibrate(short)


@pytest.mark.parametrize("mount", ["flange", "base"])
def test_it_is_saved_and_loaded(mount: str, tmp_path: Path) -> None:
    made = cell(mount=mount, repeats=2, poses=8).dataset
    save(made, tmp_path / "cell")
    loaded = robolaser.load(tmp_path / "cell")
    np.testing.assert_array_equal(loaded.points["profile"], made.points["profile"])
    assert (loaded.options, loaded.radius_m) == (made.options, made.radius_m)
    described = tmp_path / "cell" / "dataset.toml"
    described.write_text(
        described.read_text().replace("radius_m = { 0 = 0.0127, 1 = 0.0127 }", "radius_m = { 0 = 0.0127 }")
    )
    with pytest.raises(
        DataError, match=r"lacks \[target\] radius_m of 1: points\.csv has points on a ball of this name"
    ):
        robolaser.load(tmp_path / "cell")


@pytest.mark.parametrize("mount", ["flange", "base"])
def test_ros_is_told_where_it_sits(mount: str) -> None:
    made = cell(mount=mount, poses=10)
    found = calibrate(made.dataset)
    words = (static_transform(found) or "").split()
    link = {"flange": made.dataset.robot.flange, "base": "world"}[mount]
    assert words[-4:] == ["--frame-id", link, "--child-frame-id", "profile_sensor"]
    place = [float(words[words.index(f"--{axis}") + 1]) for axis in "xyz"]
    np.testing.assert_allclose(place, [found.value(f"hand_eye.{axis}") for axis in "xyz"], atol=1e-8)


def test_a_standing_sensor_has_no_bracket() -> None:
    rides, stands = (cell(mount=mount).dataset for mount in ("flange", "base"))
    assert candidate_effects(["hand_eye_sag"], rides)
    with pytest.raises(robolaser.errors.EffectError, match="no bracket"):
        candidate_effects(["hand_eye_sag"], stands)


def test_what_is_wrong_with_the_cell_is_named() -> None:
    found = examine(cell(poses=25, effects={"joint_offset:elbow_joint": 2e-3}).dataset, seed=0)
    assert found.verdict == "explained"
    assert str(found.findings[0].candidate_effect) == "joint_offset at elbow_joint"
