"""Images of a drawn board, imported with the arm's poses, lead to where the camera is, in two commands."""

import json

import cv2
import numpy as np
from test_hand_eye_pairs import assert_near, motion

from examples import csv, industrial_calibration, written
from robolaser.cli import main
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose, to_quaternion

K = np.array([[900.0, 0, 479.5], [0, 900, 359.5], [0, 0, 1]])
SQUARE_M, PX_PER_SQUARE = 0.036, 120
T_BASE_CAMERA = pose(exp_so3(np.array([0.3, -2.0, 0.4])), np.array([0.8, 0.2, 0.6]))
T_FLANGE_TARGET = pose(exp_so3(np.array([1.0, 0.2, 0.5])), np.array([0.03, 0.01, 0.1]))


def seen(pattern: np.ndarray, T_camera_target: np.ndarray) -> np.ndarray:
    """The board as a pinhole sees it, its frame at the corner of the pattern."""
    scale = SQUARE_M / PX_PER_SQUARE
    to_board = np.array([[scale, 0, scale / 2], [0, scale, scale / 2], [0, 0, 1]])  # from the middles of pixels
    H = K @ T_camera_target[:3][:, [0, 1, 3]] @ to_board
    return cv2.warpPerspective(pattern, H, (960, 720), flags=cv2.INTER_AREA, borderValue=255)


def test_a_folder_of_images_with_a_table_of_poses_is_calibrated(tmp_path, capsys):
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    board = cv2.aruco.CharucoBoard((5, 7), SQUARE_M, SQUARE_M / 2, dictionary)
    pattern = board.generateImage((5 * PX_PER_SQUARE, 7 * PX_PER_SQUARE), marginSize=0)
    rng = np.random.default_rng(2)
    rows: list[list[object]] = [["image", "x", "y", "z", "qx", "qy", "qz", "qw"]]
    raw = tmp_path / "raw"
    raw.mkdir()
    for i in range(10):
        place = np.array([-0.09, -0.12, 0.42]) + rng.normal(0, 0.02, 3)
        T_camera_target = pose(exp_so3(rng.normal(0, 0.35, 3)), place)
        T = T_BASE_CAMERA @ T_camera_target @ inverse(T_FLANGE_TARGET)
        cv2.imwrite(str(raw / f"{i}.png"), seen(pattern, T_camera_target))
        rows.append([f"{i}.png", *(T[:3, 3] * 1e3).tolist(), *to_quaternion(T[:3, :3]).tolist()])
    written(raw / "poses.csv", rows, separator=",", decimal=".")
    columns = [word for axis in "xyz" for word in ("--column", f"poses.{axis}_m={axis}")]
    stated = ["--set", "mount=base", "--set", "board=charuco,4x6,36mm,18mm,DICT_6X6_250", "--units", "mm"]
    assert main(["import", str(raw), *columns, *stated, "--extract", "--output", str(tmp_path / "cell")]) == 0
    assert "points in 10 poses" in capsys.readouterr().out
    assert main(["calibrate", str(tmp_path / "cell"), "--output", str(tmp_path / "result"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    values = {name: one["value"] for name, one in found["parameters"].items()}
    np.testing.assert_allclose(values["fx"], 900, rtol=5e-3)
    assert_near(motion(values, "hand_eye"), T_BASE_CAMERA, 3e-3)
    assert found["rows"][0]["rms"] < 0.3


def test_images_that_show_no_board_are_said_and_nothing_is_written(tmp_path, capsys):
    raw = tmp_path / "raw"
    raw.mkdir()
    industrial_calibration(raw)
    assert main(["import", str(raw), "--extract", "--output", str(tmp_path / "cell")]) == 1
    said = capsys.readouterr().err
    assert said.startswith("robolaser: ")
    assert said.count("\n") == 1
    assert not (tmp_path / "cell").exists()


def test_there_is_nothing_to_extract_from_files_without_images(tmp_path, capsys):
    sources, said = csv(tmp_path)
    assert main(["import", *map(str, sources), *said, "--extract", "--output", str(tmp_path / "cell")]) == 2
    assert "--extract: csv found no images" in capsys.readouterr().err
    assert not (tmp_path / "cell").exists()
