"""Bodies seen in six dimensions: A X = Z B with nothing given, and what such data can and cannot say."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from asked import simulate_as_asked

import robolaser
from robolaser.arrays import Array
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import as_json
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.diagnosis import examine
from robolaser.errors import DataError, EstimationError
from robolaser.estimation.averaging import AveragedData
from robolaser.geometry.rigid_motion import from_quaternion, inverse, pose, to_quaternion
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import SIX, motion
from robolaser.parameters import Parameter
from robolaser.report.calibration.page import figures
from robolaser.report.error_analysis import ErrorAnalysis
from robolaser.robot.by_name import find_robot
from robolaser.simulation import Simulated

ROBOT = find_robot("ur5")
TAGS = Noise(point_m=1e-3, angle_rad=1e-2)
CAPTURED = Noise(point_m=1e-4, angle_rad=1e-3)


def cell(noise: Noise | None = CAPTURED, **more: object) -> Simulated:
    return simulate_as_asked(ROBOT, kind="pose", noise=noise, **{"poses": 30, "seed": 1, **more})


def turned_by(made: Simulated, degrees: float, width: float) -> Dataset:
    """The data set on flange poses with a body whose nominal place is turned about its own z."""
    given = {}
    for part in SIX:
        name, unit = f"tool.0.{part}", "rad" if part in SIX[3:] else "m"
        at = made.truth[name] + (np.radians(degrees) if part == "psi" else 0.0)
        given[name] = Parameter(name, unit, at, at - width, at + width)
    poses = Poses(made.dataset.poses.names, T_base_flange=made.dataset.flange())
    return replace(made.dataset, robot=None, poses=poses, parameters=given)


@pytest.mark.parametrize("seed", range(3))
def test_wherever_base_and_bodies_are_they_are_found_with_nothing_given(seed: int) -> None:
    made = cell(seed=seed, points=2, poses=12)
    found = calibrate(made.dataset, Plan(weights="noise"))
    values = found.model.parameters.values(found.x[None])
    truth = {name: np.array([value]) for name, value in made.truth.items()}
    for place in ("base", "tool.0", "tool.1"):
        apart = inverse(motion(truth, place)) @ motion(values, place)
        np.testing.assert_allclose(apart[0], np.eye(4), atol=5e-3)
    of_rows = {row["unit"]: row for row in as_json(found)["rows"]}
    assert of_rows["m"]["rms"] == pytest.approx(np.sqrt(3) * CAPTURED.point_m, rel=0.3)
    assert of_rows["rad"]["rms"] == pytest.approx(np.sqrt(3) * CAPTURED.angle_rad, rel=0.3)
    assert of_rows["rad"]["rms"] < of_rows["rad"]["held_out_rms"] < 2.0 * of_rows["rad"]["rms"]


def test_a_camera_on_the_flange_is_the_same_case_with_its_poses_inverted() -> None:
    made = cell(noise=None)
    points = made.dataset.points
    T_base_flange = made.dataset.flange()
    T_flange_camera = motion({name: np.array([value]) for name, value in made.truth.items()}, "tool.0")[0]
    T_tag_base = motion({name: np.array([value]) for name, value in made.truth.items()}, "base")[0]
    T_tag_camera = inverse(inverse(T_tag_base @ T_base_flange @ T_flange_camera))
    quaternion = to_quaternion(T_tag_camera[:, :3, :3])
    seen = replace(points, xyz=T_tag_camera[:, :3, 3], columns={"quaternion": quaternion})
    found = calibrate(replace(made.dataset, points=seen, noise=TAGS))
    np.testing.assert_allclose(found.x, [made.truth[name] for name in found.model.parameters.names], atol=1e-7)


def test_a_bracket_that_is_171_degrees_off_is_found_not_fitted_around() -> None:
    made = cell(poses=15)
    wide = calibrate(turned_by(made, 171.0, 4.0))
    assert wide.rms_m == pytest.approx(calibrate(made.dataset).rms_m, rel=1e-6)
    narrow = calibrate(turned_by(made, 171.0, 0.2))
    said = [warning for warning in narrow.warnings if warning.startswith("The data put tool.0 171° and ")]
    assert len(said) == 1
    assert "Delete tool.0.* there" in said[0]


@pytest.mark.parametrize("keep", [np.zeros_like, lambda R: R * np.eye(6)[5]], ids=["one orientation", "one axis"])
@pytest.mark.parametrize("do", [robolaser.calibrate, examine], ids=["calibrate", "diagnose"])
def test_a_flange_that_does_not_turn_about_two_axes_is_refused_in_a_sentence(keep, do) -> None:
    made = cell()
    T = made.dataset.robot.forward(keep(np.random.default_rng(0).uniform(-1.0, 1.0, (30, 6)))[None])[0]
    T[:, :3, 3] += np.random.default_rng(1).uniform(-0.2, 0.2, (30, 3))
    poses = replace(made.dataset.poses, q=None, T_base_flange=T)
    with pytest.raises(EstimationError, match=r"turn the flange about two axes"):
        do(replace(made.dataset, poses=poses, robot=None))


def test_metres_and_radians_are_weighed_by_their_noise_whatever_weights_are_asked_for() -> None:
    made = cell(noise=TAGS, poses=40)
    plain, weighed = (calibrate(made.dataset, Plan(weights=weights)) for weights in ("plain", "noise"))
    np.testing.assert_allclose(plain.x, weighed.x, atol=0.1 * np.nanmax(weighed.std))
    silent = calibrate(replace(made.dataset, noise=Noise()))
    assert silent.held_out_rms_m == pytest.approx(weighed.held_out_rms_m, rel=0.1)


def test_standard_errors_are_those_of_repeated_experiments() -> None:
    def standardized(seed: int) -> Array:
        made = cell(seed=seed, poses=15)
        found = calibrate(made.dataset, Plan(weights="noise"))
        return (found.x - [made.truth[name] for name in found.model.parameters.names]) / found.std

    z = np.array([standardized(seed) for seed in range(20, 28)])
    assert np.mean(z**2) == pytest.approx(1.0, abs=0.45)


def test_repeats_are_averaged_as_rotations_whatever_sign_their_quaternions_have() -> None:
    made = cell(repeats=4, poses=8).dataset
    sign = np.random.default_rng(0).choice([-1.0, 1.0], (len(made.points), 1))
    flipped = replace(made.points, columns={"quaternion": sign * made.points["quaternion"]})
    either = [AveragedData.of(replace(made, points=points)).dataset.points for points in (made.points, flipped)]
    R, R_flipped = (from_quaternion(points["quaternion"]) for points in either)
    np.testing.assert_allclose(R, R_flipped, atol=1e-15)
    assert len(either[0]) == 8


def test_it_is_saved_and_loaded_and_its_quaternions_are_checked(tmp_path: Path) -> None:
    made = cell().dataset
    save(made, tmp_path / "cell")
    loaded = robolaser.load(tmp_path / "cell")
    np.testing.assert_array_equal(loaded.points["quaternion"], made.points["quaternion"])
    assert loaded.noise == CAPTURED
    points = tmp_path / "cell" / "points.csv"
    header, first, *rest = points.read_text().splitlines()
    points.write_text("\n".join([header, ",".join([*first.split(",")[:-1], "3.0"]), *rest]))
    with pytest.raises(DataError, match=r"points\.csv, row 2, columns qx qy qz qw: the quaternion .* has length"):
        robolaser.load(tmp_path / "cell")


def test_a_known_distance_between_bodies_fixes_the_trackers_scale() -> None:
    effects = {"tracker_scale": 2e-3}
    made = cell(points=2, poses=40, effects=effects).dataset
    truth = cell(points=2, poses=40, effects=effects).truth
    apart = float(np.linalg.norm([truth[f"tool.1.{part}"] - truth[f"tool.0.{part}"] for part in "xyz"]))
    known = replace(made, distances_m=(("0", "1", apart),), noise=replace(CAPTURED, distance_m=1e-6))
    found = calibrate(known, Plan(effects=("tracker_scale",), weights="noise"))
    assert found.value("tracker_scale.measuring_system.scale") == pytest.approx(2e-3, abs=4 * found.std[-1])
    assert [row["sensor"] for row in as_json(found)["rows"]] == ["pose", "pose", "distances"]


def test_a_person_reads_degrees() -> None:
    found = calibrate(cell().dataset)
    turns = [figure for figure in figures(ErrorAnalysis(found)) if figure.value.endswith("°")]
    assert [figure.label for figure in turns] == ["new poses, rotation", "fitted, rotation"]


def test_the_exported_frame_is_turned_as_the_body_is() -> None:
    made = cell(noise=None)
    model = Model(made.dataset)
    truth = {name: np.array([value]) for name, value in made.truth.items()}
    (frame,) = model.blocks.sensor.in_cell(truth, model.perturb({})).flange.values()
    np.testing.assert_allclose(frame, motion(truth, "tool.0")[0])


def test_a_bracket_that_slips_is_the_same_for_all_bodies_that_it_carries() -> None:
    made = cell(noise=None, points=2, poses=10, effects={"hand_eye_drift": 1e-3})
    model = Model(made.dataset, made.effects)
    truth = {name: np.array([value]) for name, value in made.truth.items()}
    assert np.abs(model.residuals_at(truth)).max() < 1e-12
    points = made.dataset.points
    T = pose(from_quaternion(points["quaternion"]), points["xyz"])
    apart = inverse(T[points.number == 0]) @ T[points.number == 1]
    np.testing.assert_allclose(apart, np.broadcast_to(apart[0], apart.shape), atol=1e-12)


@pytest.mark.parametrize("effect", ["backlash:shoulder_lift_joint", "tracker_scale:measuring_system"])
def test_what_is_wrong_with_the_cell_is_named(effect: str) -> None:
    found = examine(cell(poses=50, effects={effect: 2e-3}).dataset, seed=0)
    assert found.verdict == "explained"
    turns = found.gap.rotations
    assert turns.after_rad == pytest.approx(np.sqrt(3.0) * CAPTURED.angle_rad, rel=0.2)
    assert turns.noise_floor_rad == pytest.approx(np.sqrt(3.0) * CAPTURED.angle_rad, rel=0.1)
    after, before, least = np.degrees([turns.after_rad, turns.calibrated_rad, turns.noise_floor_rad])
    assert f"is {after:.3g}° ({before:.3g}° without that), where noise alone gives {least:.3g}°." in found.sentence
    most_important = found.findings[0].candidate_effect
    assert f"{most_important.effect.name}:{most_important.where}" == effect
