"""A camera on the flange or in the cell: OpenCV's projection, a start from nothing, what is fixed stays fixed."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from asked import simulate_as_asked

import robolaser
from robolaser.calibration.calibrate import calibrate
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.stated_noise import Noise
from robolaser.errors import DataError, EstimationError
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.model.sensors.camera import CameraSensor
from robolaser.model.sensors.camera_projection import distort, straighten, to_pixels
from robolaser.model.sensors.in_cell import Mounting
from robolaser.model.sensors.placements import motion
from robolaser.model.stages import Perturbation
from robolaser.parameters import Parameter
from robolaser.robot.by_name import find_robot
from robolaser.simulation import Simulated

ROBOT = find_robot("ur5")
NOISE = Noise(pixel_px=0.1)
LENS = {"fx": 900.0, "fy": 905.0, "cx": 640.0, "cy": 360.0, "k1": -0.2, "k2": 0.1, "p1": 1e-3, "p2": -2e-3, "k3": 0.05}
VALUES = {name: np.array([value]) for name, value in LENS.items()}
CELLS = [("flange", False), ("flange", True), ("base", False)]


def cell(mount: str = "flange", *, placed: bool = False, **options: object) -> Simulated:
    return simulate_as_asked(ROBOT, kind="camera", mount=mount, placed=placed, **{"poses": 12, "seed": 3, **options})


def truth_of(made: Simulated, model: Model) -> np.ndarray:
    return np.array([made.truth[name] for name in model.parameters.names])


def seen_from(made: Simulated, T_base_flange: np.ndarray) -> Dataset:
    """The same cell with other flange poses, which were measured."""
    poses = Poses(made.dataset.poses.names, T_base_flange=T_base_flange)
    data = replace(made.dataset, robot=None, poses=poses)
    blocks = Blocks(data)
    values = {name: np.array([made.truth[name]]) for name in blocks.derived}
    off = blocks.residuals(values, T_base_flange[None], Perturbation())[0]
    pixel = data.points.pixel - off + NOISE.pixel_px * np.random.default_rng(1).standard_normal(off.shape)
    return replace(data, points=replace(data.points, pixel=pixel))


def test_points_are_seen_where_opencv_sees_them() -> None:
    points = np.random.default_rng(0).uniform((-0.4, -0.3, 0.8), (0.4, 0.3, 1.5), (50, 3))
    K = np.array([[LENS["fx"], 0, LENS["cx"]], [0, LENS["fy"], LENS["cy"]], [0, 0, 1]])
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, np.array(list(LENS.values())[4:]))
    straight = (points[:, :2] / points[:, 2:])[None]
    np.testing.assert_allclose(to_pixels(distort(straight, VALUES), VALUES)[0], expected[:, 0], atol=1e-9)


def test_straightening_undoes_the_lens() -> None:
    straight = np.random.default_rng(0).uniform(-0.4, 0.4, (1, 50, 2))
    np.testing.assert_allclose(straighten(to_pixels(distort(straight, VALUES), VALUES), VALUES), straight, atol=1e-9)


@pytest.mark.parametrize(("mount", "placed"), CELLS)
def test_with_nothing_given_it_starts_from_its_boards_and_ends_at_the_truth(mount: str, placed: bool) -> None:
    made = cell(mount, placed=placed, poses=20, noise=NOISE)
    assert not made.dataset.parameters
    result = calibrate(made.dataset)
    assert np.sqrt(np.mean(((result.x - truth_of(made, result.model)) / result.std) ** 2)) < 2.0
    assert np.sqrt(np.mean(result.residuals**2)) == pytest.approx(NOISE.pixel_px, rel=0.1)
    (rows,) = result.row_errors
    assert (rows.sensor, rows.unit) == ("camera", "px")
    assert rows.held_out_rms == pytest.approx(np.sqrt(2) * NOISE.pixel_px, rel=0.2)


def test_it_starts_from_the_same_bits_however_many_threads_opencv_has() -> None:
    dataset = cell(poses=30, noise=NOISE).dataset
    threads, starts = cv2.getNumThreads(), []
    try:
        for count in (1, 2, 2, 2):
            cv2.setNumThreads(count)
            starts.append(Model(dataset).parameters.nominal)
    finally:
        cv2.setNumThreads(threads)
    assert all(np.array_equal(starts[0], start) for start in starts)


def test_a_bracket_that_is_half_a_turn_off_is_found_and_not_fitted_around() -> None:
    made = cell(poses=16, noise=NOISE)
    turned = made.truth["hand_eye.w"] - np.deg2rad(171.0)
    near = Parameter("hand_eye.w", "rad", turned, turned - np.pi, turned + np.pi)
    result = calibrate(replace(made.dataset, parameters={"hand_eye.w": near}))
    away = result.value("hand_eye.w") - made.truth["hand_eye.w"]
    assert abs((away + np.pi) % (2.0 * np.pi) - np.pi) < 0.01
    assert np.sqrt(np.mean(result.residuals**2)) == pytest.approx(NOISE.pixel_px, rel=0.1)


def test_what_is_fixed_stays_and_the_rest_is_found_with_it() -> None:
    made = cell(poses=16, noise=NOISE)
    fixed = {name: made.truth[name] for name in ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")}
    given = {name: Parameter(name, "", value, value, value) for name, value in fixed.items()}
    result = calibrate(replace(made.dataset, parameters=given))
    for name, value in fixed.items():
        assert result.value(name) == value
    assert np.isnan(result.std[: len(fixed)]).all()
    assert not result.unidentifiable
    for part in "xyz":
        assert result.value(f"hand_eye.{part}") == pytest.approx(made.truth[f"hand_eye.{part}"], abs=1e-4)


def test_residuals_are_told_in_millimetres_at_the_target() -> None:
    made = cell(poses=8)
    model = Model(made.dataset)
    x = truth_of(made, model)
    values = model.parameters.values(x[None])
    depth = model.blocks.sensor.in_camera(values, model.flange(values), Perturbation())[0, :, 2]
    there = model.in_metres(x, np.full((len(depth), 2), 1.0))
    np.testing.assert_allclose(there, depth[:, None] / [made.truth["fx"], made.truth["fy"]], rtol=1e-12)


@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_a_flange_that_hardly_turns_tells_what_its_travel_shows(turn: float) -> None:
    made = cell(poses=16, noise=NOISE)
    T, rng = made.dataset.flange(), np.random.default_rng(0)
    turns = T[0, :3, :3] @ exp_so3(np.outer(np.linspace(-turn, turn, 16), [0.0, 0.0, 1.0]))
    found = calibrate(seen_from(made, pose(turns, T[0, :3, 3] + rng.uniform(-0.05, 0.05, (16, 3)))))
    assert found.rms_m < 1e-4
    for angle in ("hand_eye.w", "hand_eye.phi", "hand_eye.psi"):
        assert found.value(angle) == pytest.approx(made.truth[angle], abs=2e-3)
    free = {name for group in found.unidentifiable for name in group.parameters}
    assert {"hand_eye.x", "hand_eye.y", "hand_eye.z"} & free
    (said,) = (warning for warning in found.warnings if "exported position" in warning)
    assert said.startswith("The flange turns about one axis only" if turn else "The flange never turns")


def test_a_flange_that_only_goes_along_a_line_gives_no_hand_eye() -> None:
    made = cell(poses=8)
    sensor = Model(made.dataset).blocks.sensor
    T = np.repeat(made.dataset.flange()[:1], 8, axis=0)
    T[:, 0, 3] += np.linspace(0.0, 0.2, 8)
    with pytest.raises(EstimationError, match="neither turns nor moves in two directions"):
        sensor.initialize({}, T[None], Perturbation())


def test_too_few_views_are_told() -> None:
    made = cell(poses=8)
    few = made.dataset.points.take(made.dataset.points.pose < 2)
    with pytest.raises(EstimationError, match="cannot be found from fewer than 3"):
        calibrate(replace(made.dataset, points=few))


def test_what_a_data_set_says_of_a_camera_reads_back_the_same(tmp_path: Path) -> None:
    made = cell("base", poses=6).dataset
    fixed = Parameter("k3", "", 0.0, 0.0, 0.0)
    board = Board(7, 5, 0.03, "charuco", 0.02, "DICT_6X6_250")
    dataset = replace(made, parameters={"k3": fixed}, board=board)
    robolaser.save(dataset, tmp_path / "cell")
    read = robolaser.load(tmp_path / "cell")
    assert (read.options, read.board, read.placed) == (Mounting("base"), board, False)
    assert read.parameters == {"k3": fixed}
    assert (read.points.pixel == dataset.points.pixel).all()
    text = (tmp_path / "cell" / "dataset.toml").read_text()
    for said, wrong in (("fixed = true", "fixed = true, lower = -1"), ("fixed = true", "lower = -1")):
        (tmp_path / "cell" / "dataset.toml").write_text(text.replace(said, wrong))
        with pytest.raises(DataError, match=r"dataset.toml, \[parameters\] k3"):
            robolaser.load(tmp_path / "cell")
    (tmp_path / "cell" / "dataset.toml").write_text(text.replace("marker_m = 0.02", "marker_m = 0.04"))
    with pytest.raises(DataError, match="less than square_m"):
        robolaser.load(tmp_path / "cell")


def test_a_target_on_the_flange_cannot_be_placed_in_the_base_frame() -> None:
    with pytest.raises(DataError, match="Write placed = false"):
        CameraSensor(replace(cell().dataset, placed=True, options=Mounting("base")))


def test_it_needs_no_robot_but_flange_poses() -> None:
    made = cell("base", poses=16, noise=NOISE)
    dataset = made.dataset
    poses = Poses(dataset.poses.names, T_base_flange=dataset.flange())
    result = calibrate(replace(dataset, robot=None, poses=poses))
    assert result.value("hand_eye.x") == pytest.approx(made.truth["hand_eye.x"], abs=1e-3)


def test_the_camera_for_others_sees_what_it_sees_itself() -> None:
    dataset: Dataset = cell(effects={"radial_distortion": 1e8}).dataset
    model = Model(dataset, candidate_effects(["radial_distortion"], dataset))
    values = model.parameters.values(model.parameters.nominal[None])
    values = {**values, "radial_distortion.camera.k_2": np.array([1e8])}
    perturb = model.perturb(values)
    straight = model.blocks.sensor.in_cell(values, perturb).camera.slopes(dataset.points["pixel"])
    seen = model.blocks.sensor._through_lens(straight[None], values, perturb)[0]
    np.testing.assert_allclose(seen, dataset.points["pixel"], atol=1e-6)


def test_it_sees_the_target_from_elsewhere_as_the_model_says() -> None:
    made = cell()
    values = {name: np.array([value]) for name, value in made.truth.items()}
    q = made.dataset.poses.q + np.random.default_rng(0).normal(0.0, 0.02, made.dataset.poses.q.shape)
    points, good = Model(made.dataset).blocks.sensor.new_poses.seen_from(values, ROBOT.forward(q[None])[0])
    assert good.any()
    there = Model(replace(made.dataset, poses=Poses(made.dataset.poses.names, q=q), points=points))
    assert np.abs(there.residuals_at(values)).max() < 1e-9


def test_hand_eye_is_the_cameras_place_on_the_flange() -> None:
    made = cell(poses=6)
    model = Model(made.dataset)
    values = {name: np.array([value]) for name, value in made.truth.items()}
    T_base_camera = model.flange(values)[0] @ motion(values, "hand_eye")[0]
    T_camera_target = inverse(T_base_camera) @ motion(values, "target")[0]
    expected = np.einsum("nij,nj->ni", T_camera_target[made.dataset.points.pose, :3, :3], made.dataset.points.xyz)
    expected += T_camera_target[made.dataset.points.pose, :3, 3]
    np.testing.assert_allclose(
        model.blocks.sensor.in_camera(values, model.flange(values), Perturbation())[0], expected, atol=1e-12
    )
