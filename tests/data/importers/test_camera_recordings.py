"""Images with poses become recordings of a camera; what files leave open is asked for, what is wrong is named."""

import shutil
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest

from examples import CAL_DATA, images, industrial_calibration, read
from robolaser.data.board import Board
from robolaser.data.importers import ImportOptions
from robolaser.data.importers.board_option import board_of
from robolaser.data.importers.image_folder import ImageFolder
from robolaser.data.importers.intrinsics import intrinsics_of_file
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
    assert board_of({"board": CHARUCO}) == Board(4, 6, 0.036, "charuco", 0.018, "DICT_6X6_250")
    assert board_of({"board": "checkerboard, 7x6, 0.01m"}) == Board(7, 6, 0.01)
    assert board_of({}) is None


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
        board_of({"board": stated})


def test_images_belong_to_rows_by_name_or_by_order(tmp_path: Path) -> None:
    raw = folder(tmp_path)
    named = read([raw], ImportOptions(columns=COLUMNS, units=("mm",), further=STATED))
    assert named.poses.image == ("images/3.png", "images/10.png", "images/20.png")
    assert named.image_px == (40, 30)
    table = raw / "poses.csv"
    table.write_text(table.read_text("utf-8-sig").replace("image", "what"), "utf-8")
    with pytest.raises(UsageError, match=r"which image belongs to which row.*--set order=sorted"):
        read([raw], ImportOptions(columns=COLUMNS, units=("mm",), further=STATED))
    by_order = read([raw], ImportOptions(columns=COLUMNS, units=("mm",), further={**STATED, "order": "sorted"}))
    assert by_order.poses.image == named.poses.image  # 10 comes after 3
    np.testing.assert_array_equal(by_order.poses.T_base_flange, named.poses.T_base_flange)
    (raw / "4.png").write_bytes((raw / "3.png").read_bytes())
    with pytest.raises(DataError, match=r"poses\.csv has 3 rows, but raw has 4 images"):
        read([raw], ImportOptions(columns=COLUMNS, units=("mm",), further={**STATED, "order": "sorted"}))


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


def test_images_and_table_may_lie_apart(tmp_path: Path) -> None:
    raw = folder(tmp_path)
    table = shutil.move(raw / "poses.csv", tmp_path / "log.csv")
    options = ImportOptions(columns=COLUMNS, units=("mm",), further=STATED)
    assert len(read([raw, table], options, "images").poses) == 3
    with pytest.raises(UsageError, match="Name a folder with images and one table"):
        ImageFolder().read([raw], options)


@pytest.mark.parametrize(
    ("left_out", "more", "expected"),
    [
        (["mount"], {}, "--set mount=flange"),
        (["board"], {}, "what is printed on the board"),
        ([], {"order": "sorted"}, "the column image names the images"),
        ([], {"hold": "intrinsics"}, "Name their file with --set intrinsics=FILE"),
    ],
)
def test_what_a_folder_leaves_open_is_asked_for(
    left_out: Sequence[str], more: dict[str, str], expected: str, tmp_path: Path
) -> None:
    stated = {key: value for key, value in {**STATED, **more}.items() if key not in left_out}
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


K, D = np.array([[900.0, 0, 320], [0, 910, 240], [0, 0, 1]]), [0.1, -0.2, 0.01, 0.02, 0.3]
EXPECTED = dict(zip(("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"), (900, 910, 320, 240, *D), strict=True))


@pytest.fixture
def ros_file(tmp_path: Path) -> Path:
    rows = f"rows: 3\n  cols: 3\n  data: {K.ravel().tolist()}"
    lens = f"distortion_model: plumb_bob\ndistortion_coefficients:\n  data: {D}"
    text = f"image_width: 640\ncamera_matrix:\n  {rows}\n{lens}\n"
    (tmp_path / "camera.yaml").write_text(text, "utf-8")
    return tmp_path / "camera.yaml"


def test_intrinsics_are_read_as_ros_and_opencv_write_them(ros_file: Path, tmp_path: Path) -> None:
    storage = cv2.FileStorage(str(tmp_path / "opencv.yml"), cv2.FILE_STORAGE_WRITE)
    storage.write("camera_matrix", K)
    storage.write("distortion_coefficients", np.array(D))
    storage.release()
    assert intrinsics_of_file(ros_file) == EXPECTED
    assert intrinsics_of_file(tmp_path / "opencv.yml") == EXPECTED


def test_intrinsics_are_fitted_from_their_values_or_held(ros_file: Path, tmp_path: Path) -> None:
    stated = {**STATED, "intrinsics": str(ros_file)}
    options = ImportOptions(columns=COLUMNS, units=("mm",), further=stated)
    fitted = read([folder(tmp_path)], options).parameters
    assert {name: one.nominal for name, one in fitted.items()} == EXPECTED
    assert not any(one.fixed for one in fitted.values())
    held = ImportOptions(columns=COLUMNS, units=("mm",), further={**stated, "hold": "intrinsics"})
    assert all(one.fixed for one in read([tmp_path / "raw"], held).parameters.values())


def test_a_lens_of_another_model_is_refused(ros_file: Path) -> None:
    ros_file.write_text(ros_file.read_text("utf-8").replace("plumb_bob", "equidistant"), "utf-8")
    with pytest.raises(DataError, match=r"equidistant.* is not OpenCV's of five numbers"):
        intrinsics_of_file(ros_file)
    ros_file.write_text(ros_file.read_text("utf-8").replace("900.0", "0.0").replace("equidistant", "plumb_bob"))
    with pytest.raises(DataError, match="no focal lengths"):
        intrinsics_of_file(ros_file)


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ("type: Charuco", "type: Aruco", "ArucoGridTargetFinder is a board that robolaser does not find"),
        ("dictionary: 10", "dictionary: 1000", "OpenCV has no dictionary 1000"),
        ("cols: 5", "cols: five", "target_finder.cols: five, expected a finite number"),
        ("  cols: 5\n", "", "target_finder lacks cols"),
        ("poses/1.yaml", "../1.yaml", "leaves the folder"),
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


def test_cal_data_is_read_with_its_parts_in_files_of_their_own(tmp_path: Path) -> None:
    industrial_calibration(tmp_path)
    file = tmp_path / "cal_data.yaml"
    whole = read([tmp_path], ImportOptions())
    finder = CAL_DATA[CAL_DATA.index("  type") : CAL_DATA.index("intrinsics")].replace("\n  ", "\n").strip()
    (tmp_path / "finder.yaml").write_text(finder.replace("Charuco", "industrial_calibration::Charuco"), "utf-8")
    file.write_text(file.read_text("utf-8").replace("target_finder:", "was:"), "utf-8")
    parts = read([tmp_path, tmp_path / "finder.yaml"], ImportOptions(), "industrial_calibration")
    assert parts.board == whole.board == Board(4, 6, 0.036195, "charuco", 0.018256, "DICT_6X6_250")
    assert parts.options.mount == "base"
    assert parts.parameters == whole.parameters
