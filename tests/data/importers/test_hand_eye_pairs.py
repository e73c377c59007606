"""Files of hand-eye tools become data sets whose calibration finds where the camera is."""

import re
from collections.abc import Callable
from pathlib import Path

import cv2
import hand_eye
import numpy as np
import pytest
from hand_eye import HandEyeCell, cell

import robolaser
from examples import read
from robolaser.calibration.calibrate import calibrate
from robolaser.cli import main
from robolaser.data.importers import ImportOptions
from robolaser.data.importers.tum import Tum
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import from_angles, inverse, pose

Writer = Callable[[Path, HandEyeCell], list[Path]]
WRITERS: list[tuple[Writer, dict[str, str], tuple[str, ...]]] = [
    (hand_eye.easy_handeye2, {}, ()),
    (hand_eye.easy_handeye, {}, ()),
    (hand_eye.moveit, {"mount": "?"}, ()),
    (hand_eye.opencv, {"mount": "?"}, ("mm",)),
]


def said(mount: str, further: dict[str, str], units: tuple[str, ...] = ()) -> ImportOptions:
    return ImportOptions(further={key: mount if value == "?" else value for key, value in further.items()}, units=units)


def calibrated(dataset: robolaser.Dataset) -> dict[str, float]:
    found = calibrate(dataset)
    return dict(zip(found.model.parameters.names, found.x.tolist(), strict=True))


def motion(values: dict[str, float], prefix: str) -> np.ndarray:
    x, y, z, w, phi, psi = (np.array(values[f"{prefix}.{part}"]) for part in ("x", "y", "z", "w", "phi", "psi"))
    return pose(from_angles(w, phi, psi), np.stack([x, y, z]))


def assert_near(T: np.ndarray, expected: np.ndarray, within: float = 1e-3) -> None:
    apart = inverse(T) @ expected
    assert np.linalg.norm(apart[:3, 3]) < within
    assert np.arccos(min(1.0, (np.trace(apart[:3, :3]) - 1) / 2)) < within


@pytest.mark.parametrize("mount", ["flange", "base"])
@pytest.mark.parametrize(("write", "further", "units"), WRITERS, ids=lambda value: getattr(value, "__name__", ""))
def test_the_camera_is_found_where_it_is(write, further, units, mount, tmp_path):
    made = cell(mount)
    dataset = read(write(tmp_path, made), said(mount, further, units))
    assert dataset.kind == "pose"
    found = calibrated(dataset)
    body = "camera" if mount == "flange" else "target"
    assert_near(motion(found, f"tool.{body}"), made.T_carried)
    assert_near(motion(found, "base"), inverse(made.T_standing))


@pytest.mark.parametrize("mount", ["flange", "base"])
def test_a_result_of_the_tool_is_where_the_calibration_starts(mount, tmp_path):
    made = cell(mount)
    dataset = read(hand_eye.easy_handeye2(tmp_path, made), ImportOptions())
    values = {name: parameter.nominal for name, parameter in dataset.parameters.items()}
    if mount == "flange":
        assert_near(motion(values, "tool.camera"), made.T_carried)
    else:
        assert_near(motion(values, "base"), inverse(made.T_standing))


def test_samples_without_a_result_leave_the_mount_to_be_said(tmp_path):
    samples = hand_eye.easy_handeye2(tmp_path, cell("base"))[:1]
    with pytest.raises(UsageError, match=r"--set mount=flange \(eye in hand\) or --set mount=base"):
        read(samples, ImportOptions())
    assert len(read(samples, said("base", {"mount": "?"})).poses) == 20
    with pytest.raises(UsageError, match="expected flange"):
        read(samples, said("hand", {"mount": "?"}))


def test_a_mount_against_the_files_word_is_refused(tmp_path):
    with pytest.raises(UsageError, match="states that the camera is mounted on the base"):
        read(hand_eye.easy_handeye2(tmp_path, cell("base")), said("flange", {"mount": "?"}))


def test_a_result_alone_is_no_data(tmp_path):
    with pytest.raises(DataError, match=r"cell\.calib is a result"):
        read(hand_eye.easy_handeye2(tmp_path, cell("base"))[1:], ImportOptions())


@pytest.mark.parametrize("name", ["pairs.yml", "pairs.xml", "pairs.json"])
@pytest.mark.parametrize("vectors", [False, True])
def test_opencv_storage_reads_the_same_in_every_format(name, vectors, tmp_path):
    made = cell("flange")
    dataset = read(hand_eye.opencv(tmp_path, made, name, vectors=vectors), said("flange", {"mount": "?"}, ("mm",)))
    np.testing.assert_allclose(dataset.poses.T_base_flange, made.T_base_flange, atol=1e-9)
    np.testing.assert_allclose(dataset.points.xyz, inverse(made.T_camera_target)[:, :3, 3], atol=1e-9)


def test_an_empty_matrix_of_opencv_beside_the_lists_is_left_out(tmp_path):
    (file,) = hand_eye.opencv(tmp_path, cell("flange"))
    empty = "distortion: !!opencv-matrix\n   rows: 0\n   cols: 0\n   dt: d\n   data: []\n"
    file.write_text(file.read_text("utf-8") + empty, "utf-8")
    dataset = read([file], said("flange", {"mount": "?"}, ("mm",)))
    assert len(dataset.poses) == len(cell("flange").T_base_flange)


def test_opencv_lists_go_the_way_that_their_names_say(tmp_path):
    made = cell("base")
    storage = cv2.FileStorage(str(tmp_path / "pairs.yml"), cv2.FILE_STORAGE_WRITE)
    for i, T in enumerate(inverse(made.T_base_flange)):
        storage.write(f"R_base2gripper_{i}", T[:3, :3].copy())
        storage.write(f"t_base2gripper_{i}", T[:3, 3].copy())
    turns = np.array([cv2.Rodrigues(T[:3, :3].copy())[0].ravel() for T in made.T_camera_target])
    storage.write("R_world2cam", turns)
    storage.write("t_world2cam", made.T_camera_target[:, :3, 3].copy())
    storage.release()
    stated = {"mount": "base"}
    dataset = read([tmp_path / "pairs.yml"], ImportOptions(further=stated, units=("m",)))
    np.testing.assert_allclose(dataset.poses.T_base_flange, made.T_base_flange, atol=1e-9)
    np.testing.assert_allclose(dataset.points.xyz, made.T_camera_target[:, :3, 3], atol=1e-9)
    with pytest.raises(UsageError, match="In which unit are lengths, such as t_base2gripper"):
        read([tmp_path / "pairs.yml"], ImportOptions(further=stated))
    text = (tmp_path / "pairs.yml").read_text("utf-8")
    (tmp_path / "pairs.yml").write_text(text.replace("world2cam", "target2camera"), "utf-8")
    with pytest.raises(DataError, match=r"lacks two lists of motions: R_target2cam and t_target2cam, or R_world2cam"):
        read([tmp_path / "pairs.yml"], ImportOptions(further=stated, units=("m",)))


def test_two_trajectories_are_matched_by_time_within_the_stated_tolerance(tmp_path):
    made = cell("base")
    paths = hand_eye.tum(tmp_path, made)
    with pytest.raises(UsageError, match="State it in seconds with --set tolerance_s"):
        read(paths, ImportOptions())
    dataset = read(paths, ImportOptions(further={"tolerance_s": "0.02"}, point="marker"))
    assert dataset.points.names == ("marker",) * 20
    assert_near(motion(calibrated(dataset), "tool.marker"), made.T_carried)
    with pytest.raises(DataError, match=r"within 0\.005 s before and after it; the nearest is 0\.007 s away"):
        read(paths, ImportOptions(further={"tolerance_s": "0.005"}))
    with pytest.raises(UsageError, match="expected seconds"):
        read(paths, ImportOptions(further={"tolerance_s": "soon"}))


def test_rows_of_a_trajectory_that_repeat_a_time_are_left_out(tmp_path):
    (tmp_path / "flange.tum").write_text("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n", "utf-8")
    imported = Tum().read([tmp_path / "flange.tum"] * 2, ImportOptions(further={"tolerance_s": "1"}))
    assert len(imported.dataset.poses) == 2
    assert "flange.tum: 1 rows, whose times repeat those of others" in imported.left_out


def test_one_trajectory_is_not_enough(tmp_path):
    with pytest.raises(UsageError, match="Expected two trajectories"):
        read(hand_eye.tum(tmp_path, cell("base"))[:1], ImportOptions())


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 2 3\n", "row 1: expected eight numbers"),
        ("1 0 0 0 0 0 0 1\n\n# x\n2 0 0 0 0 0 0 2\n", "row 4, columns qx qy qz qw: the quaternion"),
        ("1 0 0 0 0 0 0 nan\n", "row 1, column qw: 'nan', expected a finite number"),
        ("# nothing\n", "no line of numbers"),
    ],
)
def test_a_wrong_line_of_a_trajectory_is_named(text, expected, tmp_path):
    (tmp_path / "flange.tum").write_text(text, "utf-8")
    with pytest.raises(DataError, match=expected):
        read([tmp_path / "flange.tum"] * 2, ImportOptions(further={"tolerance_s": "1"}), "tum")


NO_COLS = "%YAML:1.0\n---\nR_gripper2base: !!opencv-matrix\n   rows: 2\n   dt: d\n   data: [ 1., 2., 3. ]\n"
SAMPLE = "samples:\n- robot: {translation: {x: 0, y: 0, z: 0}, rotation: {x: 0, y: 0, z: 0, w: 1}}\n"


@pytest.mark.parametrize(
    ("kind", "text", "expected"),
    [
        ("easy_handeye", SAMPLE, "sample 1 lacks tracking"),
        ("easy_handeye", SAMPLE.replace("w: 1", "w: 2") + "  tracking: 1\n", "sample 1, robot: the quaternion"),
        (
            "easy_handeye",
            SAMPLE.replace("x: 0", "x: .inf") + "  tracking: 1\n",
            "robot.translation.x: inf, expected a finite",
        ),
        ("easy_handeye", SAMPLE.replace("x: 0", f"x: {10**400}") + "  tracking: 1\n", "expected a finite number"),
        ("easy_handeye", "samples: []\n", "has no samples"),
        ("easy_handeye", "{samples: {hand_world_samples: [1], camera_marker_samples: []}}", "two lists of one length"),
        ("easy_handeye", "a: &a [*a]\n", "holds neither samples nor a result"),
        ("easy_handeye", "[" * 500, "not valid YAML"),
        ("easy_handeye", "samples: !!python/object:os.system {}", "not valid YAML"),
        ("moveit", "- effector_wrt_world: [1, 2]\n", "sample 1, effector_wrt_world: .*expected 16 finite numbers"),
        ("moveit", f"- effector_wrt_world: [{', '.join('1' * 16)}]\n", "not a rigid motion"),
        ("opencv", "<opencv_storage><a>", "OpenCV does not read it"),
        ("opencv", "%YAML:1.0\n---\nR_gripper2base: 3\nt_gripper2base: 3\n", "expected a list of entries"),
        ("opencv", NO_COLS, "the 3 numbers of a matrix do not fill 2 rows"),
    ],
)
def test_a_wrong_entry_is_named_and_nothing_is_written(kind, text, expected, tmp_path, capsys):
    (tmp_path / "raw").mkdir()
    path = tmp_path / "raw" / "samples.yaml"
    path.write_text(text, "utf-8")
    words = ["import", str(path), "--kind", kind, "--set", "mount=base", "--output", str(tmp_path / "cell")]
    assert main([*words, *(["--units", "m"] if kind == "opencv" else [])]) == 1
    shown = capsys.readouterr().err
    assert "samples.yaml" in shown
    assert re.search(expected, shown), shown
    assert not (tmp_path / "cell").exists()
