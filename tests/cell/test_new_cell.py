"""A new cell of every arm with a driver: its plan sees the board and hits nothing, and its board has true size."""

import io
import json
import re
import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

import robolaser
from robolaser.cell.arm import arm_class
from robolaser.cell.first_plan import layout
from robolaser.cell.plan_validation import RouteCheck
from robolaser.cell.route import from_table, way
from robolaser.cli import main
from robolaser.data.board import Board, board_pdf
from robolaser.data.cell_config import load_cell
from robolaser.emulator.emulated_cell import CONTROLLERS
from robolaser.emulator.world.world import load_world
from robolaser.robot.by_name import known_robots
from robolaser.vision.target import target_in

DRIVEN = [robot.name for robot in known_robots() if robot.controller]
BOARD = Board(10, 7, 0.02, "charuco", 0.015, "DICT_4X4_100")
POINTS_A_M = 72 / 0.0254


@pytest.fixture(params=DRIVEN, scope="module")
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("new") / request.param
    assert main(["new", "cell", request.param, "--camera", "--poses", "4", "--output", str(made), "--quiet"]) == 0
    return made


def test_it_can_be_recorded_with_and_guesses_no_parameter(folder):
    cell = load_cell(folder)
    assert arm_class(cell).follows == (cell.arm.setpoint_hz is not None) == (folder / "motions.csv").is_file()
    assert cell.description.kind == "camera"
    assert not cell.description.parameters
    assert cell.description.board == BOARD


def test_its_plans_hit_nothing_and_look_at_the_board_from_different_sides(folder):
    cell = load_cell(folder)
    at, poses = layout(cell), from_table(folder / "poses.csv", cell.robot)
    T = cell.robot.forward(np.array([pose.q for pose in poses])[None])[0] @ at.T_flange_camera
    reached = T[:, :3, 3] + T[:, :3, 2] * (-T[:, 2, 3] / T[:, 2, 2])[:, None]  # where the view meets the table
    place = (reached - at.T_base_board[:3, 3]) @ at.T_base_board[:3, :3] / BOARD.square_m
    assert ((place[:, :2] > 0) & (place[:, :2] < [BOARD.columns - 1, BOARD.rows - 1])).all()
    assert (T[:, :3, 2] @ T[:, :3, 2].T).min() < np.cos(0.2)
    for name in ("poses.csv", "motions.csv"):
        if (folder / name).is_file():
            route = from_table(folder / name, cell.robot)
            assert [pose.name for pose in route] == [pose.name for pose in poses]
            assert not RouteCheck.of(cell).violations(None, *way(route))


def test_it_can_be_tried_without_hardware_where_the_arm_can_be_emulated(folder):
    cell = load_cell(folder)
    assert (folder / "world.toml").is_file() == (cell.arm.kind in CONTROLLERS)
    if cell.arm.kind in CONTROLLERS:
        world = load_world(folder / "world.toml", cell.description)
        for pose in from_table(folder / "poses.csv", cell.robot)[::2]:
            world.follow(pose.q)
            image = world.photograph(np.random.default_rng(1), lit=False)
            assert sum(np.isfinite(grid).all(axis=-1).sum() for grid in target_in(image, BOARD)) >= 8


def printed(pdf: bytes) -> tuple[np.ndarray, float]:
    """The page as an image, and the size of a pixel when it is printed at 100 % [m]."""
    found = re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", pdf)
    size = [int(n) for n in re.findall(rb"/(?:Width|Height) (\d+)", pdf)]
    stream = re.search(rb"CCITTFaxDecode.*?stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL)
    width, height, data = *size, stream[1]
    tags = {256: width, 257: height, 258: 1, 259: 4, 262: 1, 273: 122, 278: height, 279: len(data)}
    entries = b"".join(struct.pack("<HHLL", tag, 4, 1, value) for tag, value in tags.items())
    tiff = (struct.pack("<2sHLH", b"II", 42, 8, len(tags)) + entries).ljust(122, b"\0") + data
    return np.asarray(Image.open(io.BytesIO(tiff)).convert("L")), float(found[1]) / POINTS_A_M / size[0]


@pytest.mark.parametrize("board", [BOARD, Board(8, 5, 0.025)], ids=["charuco", "checkerboard"])
def test_the_board_is_found_on_its_page_and_has_true_size(board):
    page, pixel_m = printed(board_pdf(board))
    assert np.array(page.shape[::-1]) * pixel_m == pytest.approx([0.297, 0.210], abs=1e-4)
    (grid, *_) = target_in(cv2.GaussianBlur(page, (0, 0), 2.0), board)
    assert np.isfinite(grid).all()
    for axis in (0, 1):
        sides = np.linalg.norm(np.diff(grid, axis=axis), axis=-1) * pixel_m
        assert sides == pytest.approx(board.square_m, abs=2e-5)


def test_nothing_of_the_users_is_overwritten(tmp_path, capsys):
    mine = tmp_path / "README.md"
    mine.write_text("mine")
    typed = ["new", "cell", "so101", "--camera", "--poses", "4", "--output", str(tmp_path)]
    assert main(typed) == 1
    assert main([*typed, "--force"]) == 1
    assert "README.md" in capsys.readouterr().err
    assert {file.name for file in tmp_path.iterdir()} <= {"README.md", ".robolaser.json"}
    assert mine.read_text() == "mine"
    mine.unlink()
    assert main(typed) == 0
    assert main(typed) == 1
    assert main([*typed, "--force"]) == 0


def test_angles_are_lerobots_where_its_calibration_is_given(tmp_path):
    servo = {"drive_mode": 0, "homing_offset": 5, "range_min": 1000, "range_max": 3000}
    joints = next(robot.joints for robot in known_robots() if robot.name == "so101")
    calibration = tmp_path / "my_arm.json"
    calibration.write_text(json.dumps({joint: {"id": i, **servo} for i, joint in enumerate(joints, start=4)}))
    typed = ["new", "cell", "so101", "--camera", "--poses", "4", "--lerobot", str(calibration)]
    assert main([*typed, "--output", str(tmp_path / "cell")]) == 0
    arm = load_cell(tmp_path / "cell").arm
    assert arm.ids == (4, 5, 6, 7, 8)
    assert arm.reference_rad == pytest.approx([(2048 - 2000) * 2 * np.pi / 4096] * 5, abs=1e-6)


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        (["panda"], "no driver for Franka"),
        (["so102"], "Did you mean"),
        (["ur5e", "--lerobot", "my_arm.json"], "Feetech"),
    ],
)
def test_what_cannot_be_is_said(typed, said, tmp_path, capsys):
    assert main(["new", "cell", *typed, "--output", str(tmp_path / "cell")]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "cell" / "cell.toml").exists()


def test_a_scanners_cell_is_one_too(tmp_path):
    assert main(["new", "cell", "scorbot_er7", "--poses", "4", "--output", str(tmp_path / "cell")]) == 0
    assert load_cell(tmp_path / "cell").description.kind == "stripe"
    assert robolaser.find_robot("scorbot_er7").joints == load_cell(tmp_path / "cell").robot.joints
