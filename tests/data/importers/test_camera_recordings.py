"""Images with poses become recordings of a camera; what files leave open is asked for, what is wrong is named."""

import re
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest

from examples import images, industrial_calibration, read
from robolaser.data.board import Board
from robolaser.data.importers import ImportOptions
from robolaser.data.importers.image_folder import ImageFolder, board_of
from robolaser.errors import DataError, UsageError

CHARUCO = "charuco,4x6,36mm,18mm,DICT_6X6_250"
STATED = {"mount": "base", "board": CHARUCO}
COLUMNS = {f"poses.{axis}_m": axis for axis in "xyz"}


def folder(tmp_path: Path) -> Path:
    raw = tmp_path / "raw"
    raw.mkdir()
    images(raw)
    return raw


def test_a_board_is_stated_on_one_line() -> None:
    assert board_of({"board": CHARUCO}, "log.csv") == Board(4, 6, 0.036, "charuco", 0.018, "DICT_6X6_250")
    assert board_of({"board": "checkerboard, 7x6, 0.01m"}, "log.csv") == Board(7, 6, 0.01)


@pytest.mark.parametrize(
    ("stated", "expected"),
    [
        ("chess,7x6,10mm", "no board of kind 'chess'"),
        ("checkerboard,7,10mm", "expected --set board=checkerboard,7x6,10mm"),
        ("checkerboard,7x6,10", "10 is no length with a unit"),
        ("checkerboard,7x6,-3mm", "-3mm is no length with a unit"),
    ],
)
def test_a_board_that_is_none_is_wrong_usage(stated: str, expected: str) -> None:
    with pytest.raises(UsageError, match=expected):
        board_of({"board": stated}, "log.csv")


def test_images_belong_to_the_rows_that_name_them(tmp_path: Path) -> None:
    raw = folder(tmp_path)
    named = read([raw], ImportOptions(columns=COLUMNS, units=("mm",), further=STATED))
    assert named.poses.image == ("images/3.png", "images/10.png", "images/20.png")
    assert named.image_px == (40, 30)
    table = raw / "poses.csv"
    table.write_text(table.read_text("utf-8-sig").replace("image", "what"), "utf-8")
    with pytest.raises(UsageError, match=r"which image belongs to each row.*--column image=NAME"):
        read([raw], ImportOptions(columns=COLUMNS, units=("mm",), further=STATED))
    assert read([raw], ImportOptions(columns={**COLUMNS, "image": "what"}, units=("mm",), further=STATED)).poses.image


def test_the_table_beside_images_may_be_one_of_arrays(tmp_path: Path) -> None:
    raw = folder(tmp_path)
    (raw / "poses.csv").unlink()
    turns = dict(zip(("qx", "qy", "qz", "qw"), np.eye(4)[[3, 3, 3]].T, strict=True))
    np.savez(raw / "log.npz", x=[100.0, 200, 300], y=np.zeros(3), z=np.ones(3), image=["10.png", "3.png", ""], **turns)
    found = read([raw], ImportOptions(columns=COLUMNS, units=("mm",), further=STATED))
    assert found.poses.image == ("images/10.png", "images/3.png", "")


def test_images_may_be_in_sub_folders(tmp_path: Path) -> None:
    raw = folder(tmp_path)
    (raw / "camera").mkdir()
    for image in raw.glob("*.png"):
        image.rename(raw / "camera" / image.name)
    found = read([raw], ImportOptions(columns=COLUMNS, units=("mm",), further=STATED))
    assert found.poses.image == ("images/3.png", "images/10.png", "images/20.png")
    (raw / "other").mkdir()
    shutil.copy(raw / "camera" / "10.png", raw / "other")
    with pytest.raises(DataError, match=r"10\.png is in several folders \(camera, other\)"):
        read([raw], ImportOptions(columns=COLUMNS, units=("mm",), further=STATED))


def test_paths_of_windows_name_the_same_images(tmp_path: Path) -> None:
    raw = folder(tmp_path)
    for image in raw.glob("*.png"):
        for camera in ("left", "right"):
            (raw / camera).mkdir(exist_ok=True)
            shutil.copy(image, raw / camera)
        image.unlink()
    table = raw / "poses.csv"
    table.write_text(re.sub(r"(\d+\.png)", r"cell\\left\\\1", table.read_text("utf-8-sig")), "utf-8")
    with pytest.raises(DataError, match="is in several folders"):
        read([raw], ImportOptions(columns=COLUMNS, units=("mm",), further=STATED))
    table.write_text(table.read_text("utf-8").replace("cell\\", ""), "utf-8")
    found = read([raw], ImportOptions(columns=COLUMNS, units_of_file={"poses.csv": ("mm",)}, further=STATED))
    assert found.poses.image == ("images/3.png", "images/10.png", "images/20.png")


def test_images_and_table_may_lie_apart(tmp_path: Path) -> None:
    raw = folder(tmp_path)
    table = shutil.move(raw / "poses.csv", tmp_path / "log.csv")
    options = ImportOptions(columns=COLUMNS, units=("mm",), further=STATED)
    assert len(read([raw, table], options, "images").poses) == 3
    with pytest.raises(UsageError, match="Name a folder with images and one table"):
        ImageFolder().read([raw], options)


@pytest.mark.parametrize(
    ("left_out", "expected"), [("mount", "--set mount=flange"), ("board", "what is printed on the board")]
)
def test_what_a_folder_leaves_open_is_asked_for(left_out: str, expected: str, tmp_path: Path) -> None:
    stated = {key: value for key, value in STATED.items() if key != left_out}
    with pytest.raises(UsageError, match=expected):
        read([folder(tmp_path)], ImportOptions(columns=COLUMNS, units=("mm",), further=stated))


def test_a_wrong_image_is_named(tmp_path: Path) -> None:
    raw = folder(tmp_path)
    options = ImportOptions(columns=COLUMNS, units=("mm",), further=STATED)
    cv2.imwrite(str(raw / "10.png"), np.zeros((30, 41), dtype=np.uint8))
    with pytest.raises(DataError, match=r"10\.png has 41 x 30 pixels, but the image before it 40 x 30"):
        read([raw], options)
    (raw / "10.png").unlink()
    with pytest.raises(DataError, match=r"poses\.csv, row 3, column image: no image 10\.png in raw"):
        read([raw], options)


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ("type: Charuco", "type: Aruco", "ArucoGridTargetFinder is a board that robolaser does not find"),
        ("dictionary: 10", "dictionary: 1000", "OpenCV has no dictionary 1000"),
        ("cols: 5", "cols: five", "target_finder.cols: five, expected a finite number"),
        ("  cols: 5\n", "", "target_finder lacks cols"),
        ("poses/1.yaml", "../1.yaml", "leaves the data set's folder"),
        ("poses/1.yaml", "poses/7.yaml", "7.yaml"),
        ("images/1.png", "images/7.png", "images/7.png is not there"),
        ("static_camera: true\n", "", "--set mount=flange"),
    ],
)
def test_a_wrong_entry_of_cal_data_is_named(before: str, after: str, expected: str, tmp_path: Path) -> None:
    industrial_calibration(tmp_path)
    file = tmp_path / "cal_data.yaml"
    text = file.read_text("utf-8")
    assert before in text
    file.write_text(text.replace(before, after), "utf-8")
    with pytest.raises((DataError, UsageError), match=expected):
        read([tmp_path], ImportOptions())


def test_cal_data_states_board_mount_and_where_to_start(tmp_path: Path) -> None:
    industrial_calibration(tmp_path)
    found = read([tmp_path], ImportOptions())
    assert found.board == Board(4, 6, 0.036195, "charuco", 0.018256, "DICT_6X6_250")
    assert found.options.mount == "base"
    start = {name: one.nominal for name, one in found.parameters.items()}
    assert [start[name] for name in ("fx", "fy", "cx", "cy", "hand_eye.y")] == [1352.0, 1356.1, 789.7, 627.3, 1.28]
    assert not any(one.fixed for one in found.parameters.values())
