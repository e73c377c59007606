"""Every mistake in a data set gets a sentence that says what is wrong, where, and what was expected."""

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.data.loading import load
from robolaser.data.writing import save
from robolaser.errors import DataError, RobolaserError
from robolaser.robot.by_name import find_robot
from robolaser.simulation import paper, simulate

Rows = list[list[str]]


@pytest.fixture(scope="session")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("data") / "good"
    save(paper(find_robot("scorbot_er7"), seed=1).dataset, folder)
    return folder


@pytest.fixture
def folder(good: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(good, tmp_path / "cell"))


def replaced(file: str, old: str, new: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        text = (folder / file).read_text()
        assert old in text
        (folder / file).write_text(text.replace(old, new, 1))

    return change


def stating(old: str, new: str) -> Callable[[Path], None]:
    return replaced("dataset.toml", old, new)


def edited(file: str, edit: Callable[[Rows], Rows]) -> Callable[[Path], None]:
    """Change the rows of a table, the header's among them."""

    def change(folder: Path) -> None:
        rows = [row.split(",") for row in (folder / file).read_text().splitlines()]
        (folder / file).write_text("\n".join(map(",".join, edit(rows))) + "\n")

    return change


def cell(file: str, line: int, column: str, value: str) -> Callable[[Path], None]:
    def edit(rows: Rows) -> Rows:
        rows[line - 1][rows[0].index(column)] = value
        return rows

    return edited(file, edit)


def with_column(column: str, first: str, second: str = "", others: str = "") -> Callable[[Path], None]:
    cells = (column, first, second, others, others, others)
    return edited("poses.csv", lambda rows: [[*row, added] for row, added in zip(rows, cells, strict=True)])


def added(file: str, text: str) -> Callable[[Path], None]:
    return lambda folder: (folder / file).write_text((folder / file).read_text() + text)


def written(file: str, text: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        (folder / file).write_text(text)

    return change


def without_column(file: str, column: str) -> Callable[[Path], None]:
    def edit(rows: Rows) -> Rows:
        gone = rows[0].index(column)
        return [[*row[:gone], *row[gone + 1 :]] for row in rows]

    return edited(file, edit)


def as_folder(file: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        (folder / file).unlink()
        (folder / file).mkdir()

    return change


MISTAKES = {
    "no dataset.toml": (lambda f: (f / "dataset.toml").unlink(), ["has no dataset.toml", "poses.csv"]),
    "no poses": (lambda f: (f / "poses.csv").unlink(), ["poses.csv", "No such file"]),
    "not TOML": (written("dataset.toml", "format = ["), ["not valid TOML", "end of document"]),
    "not text": (lambda f: (f / "poses.csv").write_bytes(b"\xff\xfe\x00"), ["poses.csv", "not UTF-8"]),
    "other format": (
        stating("dataset/1", "dataset/2"),
        ["dataset/2", "robolaser-dataset/1"],
    ),
    "no format": (stating("format", "fromat"), ["lacks format"]),
    "wrong kind": (stating('"stripe"', '"laser"'), ["[sensor] kind", "'laser'", '"socket"']),
    "wrong axis": (stating('axis = "u"', 'axis = "x"'), ["stripe_axis", '"u" or "v"']),
    "width beyond all images": (
        stating("width_px = 640", f"width_px = 1{'0' * 400}"),
        ["[image] width_px: 1000", "1 to 100000"],
    ),
    "points.csv a folder": (as_folder("points.csv"), ["points.csv", "not a regular file"]),
    "repeat beyond all numbers": (
        written("points.csv", "pose,point,repeat,u_px,v_px,x_m,y_m,z_m\n0,1,1e308,1,1,1,1,1\n"),
        ["row 2, column repeat: '1e+308'", "whole number"],
    ),
    "width a text": (
        stating("width_px = 640", 'width_px = "640"'),
        ["[image] width_px", "whole number"],
    ),
    "no width": (stating("width_px = 640", ""), ["lacks [image] width_px"]),
    "swapped bounds": (stating("upper = 0.01 ", "upper = 0.001 "), ["[parameters] f", "below upper"]),
    "nominal outside": (stating("nominal = 0.008", "nominal = 0.08"), ["nominal 0.08", "between"]),
    "no upper": (stating(", upper = 0.01 ", ""), ["[parameters] f: upper is missing"]),
    "bound not finite": (stating("upper = 0.01 ", "upper = inf "), ["f.upper", "finite"]),
    "degrees in bounds": (
        stating("lower = 0.0, upper = 0.785", "lower = 0.0, upper = 45.785"),
        ["theta", "degrees"],
    ),
    "unknown parameter": (stating("theta =", "thetta ="), ["thetta", "theta"]),
    "bound beyond all numbers": (
        stating("upper = 0.01 ", f"upper = 1{'0' * 400} "),
        ["f.upper", "finite"],
    ),
    "focal length of zero": (
        stating("lower = 0.006", "lower = 0.0"),
        ["[parameters] f: lower is 0", "above zero"],
    ),
    "quaternion": (stating("[0.0, 0.0, 0.0, 1.0]", "[0.0, 0.0, 1.0, 1.0]"), ["bracket_quat", "1.414"]),
    "gravity of four numbers": (
        stating("[sensor]", "gravity = [0, 0, 0, inf]\n[sensor]"),
        ["[robot] gravity", "finite"],
    ),
    "noise negative": (added("dataset.toml", "\n[noise]\npixel_px = -1\n"), ["[noise] pixel_px", "positive"]),
    "urdf elsewhere": (stating('"robot.urdf"', '"../robot.urdf"'), ["../robot.urdf", "leaves"]),
    "urdf absolute": (stating('"robot.urdf"', '"/etc/passwd"'), ["/etc/passwd", "leaves"]),
    "robot unknown": (stating('"robot.urdf"', '"ur55"'), ["dataset.toml", "[robot] urdf", "'ur5'"]),
    "urdf missing": (stating('"robot.urdf"', '"rob.urdf"'), ["rob.urdf", "no such file"]),
    "urdf no path": (stating('"robot.urdf"', '"a\\u0000b.urdf"'), ["[robot] urdf", "leaves"]),
    "unknown flange": (stating('"flange"', '"flangge"'), ["flangge", "Did you mean 'flange'"]),
    "unknown joint": (stating('"joint_1"', '"joint_9"'), ["joint_9", "joint_1"]),
    "joint twice": (stating('"joint_1"', '"joint_2"'), ["joints"]),
    "pose missing": (without_column("poses.csv", "pose"), ["poses.csv has no column 'pose'"]),
    "joint column missing": (without_column("poses.csv", "q_joint_3"), ["q_joint_3", "poses.csv"]),
    "NaN": (cell("points.csv", 4, "u_px", "nan"), ["points.csv, row 4, column u_px", "finite"]),
    "Python's digits": (
        cell("points.csv", 3, "u_px", "1_0"),
        ["row 3, column u_px: '1_0'", "a finite number"],
    ),
    "other digits": (
        cell("points.csv", 3, "u_px", "\u0663\u0664"),
        ["row 3, column u_px", "a finite number"],
    ),
    "empty cell": (cell("poses.csv", 3, "q_joint_2", ""), ["row 3, column q_joint_2: empty"]),
    "degrees": (cell("poses.csv", 2, "q_joint_3", "41.2"), ["row 2: q_joint_3 is 41.2 rad", "Are these degrees?"]),
    "millimetres": (cell("points.csv", 2, "x_m", "462.1"), ["row 2, column x_m", "millimetres"]),
    "pixel outside": (cell("points.csv", 2, "v_px", "481"), ["points.csv, row 2, column v_px: pixel", "640 x 480"]),
    "unknown pose": (cell("points.csv", 2, "pose", "77"), ["points.csv, row 2, column pose: no pose '77'"]),
    "pose twice": (edited("poses.csv", lambda rows: [*rows, rows[1]]), ["poses.csv, row 7", "already in row 2"]),
    "point twice": (edited("points.csv", lambda rows: [*rows, rows[2]]), ["points.csv, row 27", "already in row 3"]),
    "short row": (added("points.csv", "0,9\n"), ["points.csv, row 27: 2 cells"]),
    "column twice": (replaced("poses.csv", "q_joint_2", "q_joint_1"), ["two columns 'q_joint_1'"]),
    "empty points": (written("points.csv", ""), ["points.csv is empty"]),
    "unknown dictionary": (
        added(
            "dataset.toml",
            "\n[board]\nkind = 'charuco'\ncolumns = 6\nrows = 4\nsquare_m = 1\nmarker_m = 0.5\ndictionary = '4X4_50'\n",
        ),
        ["[board] dictionary: '4X4_50', expected one of OpenCV's: DICT_4X4_100, ", "Did you mean 'DICT_4X4_50'?"],
    ),
    "one pixel": (
        edited("points.csv", lambda rows: [rows[0], *([*row[:2], "0", "0", *row[4:]] for row in rows[1:])]),
        ["points.csv, row 2: all points of pose 0 are at one pixel, (0, 0)", "right columns"],
    ),
    "no rows": (written("points.csv", "pose,point,u_px,v_px,x_m,y_m,z_m\n"), ["no rows"]),
    "no points": (lambda f: (f / "points.csv").unlink(), ["robolaser extract"]),
    "open quote": (added("points.csv", '"0,9,1,1,1,1,1\n'), ["points.csv", "line 27"]),
    "broken URDF": (written("robot.urdf", "<robot><link"), ["robot.urdf"]),
    "one pose": (edited("points.csv", lambda rows: rows[:6]), ["1 pose with points", "at least"]),
    "poses all alike": (
        edited("poses.csv", lambda rows: [rows[0], *([name, *rows[1][1:]] for name, *_ in rows[1:])]),
        ["5 poses", "only 1 differs", "at least"],
    ),
    "target behind the camera": (
        stating("[0.0, 0.0, 0.0, 1.0]", "[1.0, 0.0, 0.0, 0.0]"),
        ["behind the camera", "bracket_quat"],
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_with_its_place(folder, mistake):
    change, expected = MISTAKES[mistake]
    change(folder)
    with pytest.raises(RobolaserError) as caught:
        calibrate(load(folder), Plan(algorithm="gauss-newton"))
    message = str(caught.value)
    for words in expected:
        assert words in message
    assert message.endswith((".", "?"))
    assert "\n" not in message
    assert "Traceback" not in message


@pytest.mark.parametrize(("column", "value"), [("u_px", "5000"), ("v_px", "-3")])
def test_a_pixel_outside_the_image_is_an_error_with_its_place(folder, column, value):
    cell("points.csv", 4, column, value)(folder)
    with pytest.raises(DataError, match=f"points.csv, row 4, column {column}: pixel .* is outside") as caught:
        load(folder)
    assert (caught.value.file, caught.value.row, caught.value.column) == ("points.csv", 4, column)


def test_a_reading_a_little_outside_the_limits_is_a_warning(folder):
    cell("poses.csv", 2, "q_joint_3", "2.5")(folder)
    assert any(w.startswith("1 reading of joint_3 is ") and "outside its limits" in w for w in load(folder).warnings)


@pytest.mark.parametrize(("payload_kg", "said"), [(3.0, False), (3000.0, True)])
def test_a_payload_that_is_heavier_than_its_arm_is_a_warning(tmp_path, payload_kg: float, said: bool):
    made = simulate(find_robot("ur5"), kind="point", poses=8, seed=1).dataset
    heavy = np.where(np.arange(8) == 3, payload_kg, 0.0)
    save(replace(made, poses=replace(made.poses, payload_kg=heavy)), tmp_path / "carried")
    found = [warning for warning in load(tmp_path / "carried").warnings if "grams" in warning]
    assert [warning.startswith("poses.csv, row 5: payload_kg is 3000") for warning in found] == [True] * said


def test_an_image_path_that_leaves_the_folder_is_refused(folder):
    with_column("image", "../secret.png")(folder)
    with pytest.raises(RobolaserError, match=r"row 2, column image.*leaves"):
        load(folder)


def test_an_unknown_socket_in_a_distance_is_named(tmp_path):
    made = simulate(find_robot("scorbot_er7"), kind="socket", poses=8, seed=1).dataset
    save(replace(made, distances_m=()), tmp_path / "s")
    stating("[target]", '[target]\ndistances_m = [["nowhere", "elsewhere", 0.05]]')(tmp_path / "s")
    with pytest.raises(RobolaserError, match=r"distances_m.*nowhere.*another point"):
        load(tmp_path / "s")


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("placed = true", "plcaed = true", "[target] plcaed: this key is not known. Did you mean 'placed'?"),
        ("[scanner]", "[scaner]", "scaner: this key is not known. Did you mean 'scanner'?"),
        ("stripe_axis", "stripe_axes", "[sensor] stripe_axes: this key is not known. Did you mean 'stripe_axis'?"),
        ("lower = 0.006", "lowr = 0.006", "[parameters] f.lowr: this key is not known. Did you mean 'lower'?"),
    ],
)
def test_a_key_that_is_not_known_is_an_error(folder, old, new, expected):
    assert load(folder).warnings == ()
    stating(old, new)(folder)
    with pytest.raises(DataError, match=re.escape(f"dataset.toml, {expected}")) as caught:
        load(folder)
    assert caught.value.file == "dataset.toml"
    assert caught.value.column == expected.partition(":")[0]


@pytest.mark.parametrize(("column", "value", "shown"), [("payload_kg", "2,5", "'2,5'"), ("temperature_c", "", "empty")])
def test_a_bad_cell_of_payload_or_temperature_is_an_error_with_its_place(folder, column, value, shown):
    with_column(column, "2.5", f'"{value}"', "2.5")(folder)
    with pytest.raises(DataError, match=rf"row 3, column {column}: {shown}, expected a finite number") as caught:
        load(folder)
    assert (caught.value.file, caught.value.row, caught.value.column) == ("poses.csv", 3, column)


def test_a_further_column_is_a_coordinate_where_it_is_numbers_and_else_a_warning(folder):
    with_column("height,operator,empty", "0,3,", "1,Ann,", "2,Ann,")(folder)
    dataset = load(folder)
    assert list(dataset.poses.coordinates) == ["height"]
    (warning,) = dataset.warnings
    assert "column operator is not a number in every row (row 3)" in warning


@pytest.mark.parametrize(("image", "warned"), [("0.png", ["1 of 5 poses have no points: 0."]), ("", [])])
def test_a_pose_without_points_is_a_warning_unless_the_arm_only_passed_it(folder, image, warned):
    with_column("image", image, "a.png", "b.png")(folder)
    edited("points.csv", lambda rows: [row for row in rows if row[0] != "0"])(folder)
    assert list(load(folder).warnings) == warned


def test_a_copy_of_a_pose_under_another_name_is_a_warning(folder):
    for file in ("poses.csv", "points.csv"):
        again = edited(file, lambda rows: [*rows, *([f"again{row[0]}", *row[1:]] for row in rows if row[0] in "02")])
        again(folder)
    (warning,) = load(folder).warnings
    assert re.match(r"2 of 7 poses are copies of others, .*: again0 \(of 0\), again2 \(of 2\)", warning)


def test_a_column_of_a_joint_that_is_not_listed_is_a_warning(folder):
    stating(', "joint_5"]', "]")(folder)
    (warning,) = load(folder).warnings
    assert "q_joint_5" in warning
    assert "neutral" in warning


@pytest.mark.parametrize("key", ["target.x", '"target.x"'])
def test_a_name_with_a_dot_is_read_with_and_without_quotes(folder, key):
    added("dataset.toml", f"\n{key} = {{ nominal = 0.1, lower = -1.0, upper = 1.0 }}\n")(folder)
    assert load(folder).parameters["target.x"].nominal == 0.1
