"""A bag recorded in a cell becomes a data set: readings at the times of what was measured, and nothing guessed."""

import cv2
import numpy as np
import pytest
from bags import FORMATS, START_S, Recorder, recorder
from hand_eye import HandEyeCell, cell
from test_hand_eye_pairs import assert_near, calibrated, motion

import robolaser
from examples import read
from robolaser.cli import main
from robolaser.data.importers import ImportOptions, importer_for
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose

ARM = "scorbot_er7"
MARKER = {
    "mount": "base", "camera": "camera", "marker": "tag", "tolerance_s": "0.02", "base": "base",
    "flange": "tool0",
}  # fmt: skip
STEP_S = 0.02


def frames(record: Recorder, made: HandEyeCell) -> None:
    """tf of an arm that stands still at each pose for a moment, and of a tag seen meanwhile."""
    record.frame(START_S, "tool0_stand", "tool0", np.eye(4), topic="/tf_static")
    for i, (flange, seen) in enumerate(zip(made.T_base_flange, made.T_camera_target, strict=True)):
        for k in (-1, 0, 1):
            record.frame(START_S + i + k * STEP_S / 2, "/base", "tool0_stand", flange)
        record.frame(START_S + i + 0.004, "camera", "tag", seen)


@pytest.mark.parametrize(("kind", "mount"), [("bag", "flange"), ("db3", "flange"), ("mcap", "base")])
def test_a_tag_and_a_flange_in_tf_are_calibrated(kind, mount, tmp_path):
    made = cell(mount)
    with recorder(tmp_path, kind) as (path, record):
        frames(record, made)
    dataset = read([path], ImportOptions(further={**MARKER, "mount": mount}))
    assert len(dataset.poses) == 20
    body = "camera" if mount == "flange" else "target"
    values = calibrated(dataset)
    assert_near(motion(values, f"tool.{body}"), made.T_carried)
    assert_near(motion(values, "base"), inverse(made.T_standing))


def moving(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Joint angles of an arm in motion, and their velocities."""
    joint = np.arange(5)
    rate = 0.3 + 0.1 * joint
    return 0.5 * np.sin(rate * t[:, None] + joint), 0.5 * rate * np.cos(rate * t[:, None] + joint)


def motion_capture(record: Recorder, *, velocities: bool = True, late_s: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Joint states at 100 Hz, a gripper's too, and a body seen at 7 Hz; gives its times and T_flange_body."""
    robot = robolaser.find_robot(ARM)
    at = np.arange(0, 7, 0.01)
    q, qd = moving(at)
    for time, angles, rates in zip(at, q, qd, strict=True):
        names, order = [*robot.joints[::-1], "finger"], [4, 3, 2, 1, 0]
        values = [np.append(one[order], 0.0) for one in (angles, rates)]
        record.joints(START_S + time, names, values[0], values[1] if velocities else np.empty(0))
    record.joints(START_S + 5.555, ["finger"], np.zeros(1), np.zeros(1))
    seen = np.arange(0.5, 6.5, 1 / 7)
    T_flange_body = pose(exp_so3(np.array([0.3, -0.2, 0.9])), np.array([0.02, 0.01, 0.08]))
    T_world_base = pose(exp_so3(np.array([0.1, 0.2, 2.0])), np.array([1.0, -0.5, 0.3]))
    for time, T in zip(seen, robot.forward(moving(seen)[0][None])[0], strict=True):
        record.pose("/mocap/body", START_S + time + late_s, T_world_base @ T @ T_flange_body)
    return START_S + seen, T_flange_body


BODY = {"mount": "base", "poses": "/mocap/body", "tolerance_s": "0.02"}


@pytest.mark.parametrize("kind", FORMATS)
def test_a_body_seen_in_motion_gets_the_joint_readings_and_velocities_of_its_times(kind, tmp_path):
    with recorder(tmp_path, kind) as (path, record):
        times, T_flange_body = motion_capture(record)
    dataset = read([path], ImportOptions(robot=robolaser.find_robot(ARM), further=BODY))
    np.testing.assert_allclose(dataset.poses.time_s, times, atol=1e-6)
    q, qd = moving(times - START_S)
    np.testing.assert_allclose(dataset.poses.q, q, atol=1e-4)
    np.testing.assert_allclose(dataset.poses.qd, qd, atol=1e-4)
    assert_near(motion(calibrated(dataset), "tool.target"), T_flange_body)


def test_what_was_dropped_is_said(tmp_path, capsys):
    with recorder(tmp_path, "db3") as (path, record):
        motion_capture(record, velocities=False)
        record.pose("/mocap/body", START_S + 60.0, np.eye(4))
    stated = [word for key, value in BODY.items() for word in ("--set", f"{key}={value}")]
    assert main(["import", str(path), "--robot", ARM, *stated, "--output", str(tmp_path / "set")]) == 0
    shown = capsys.readouterr().out
    assert "1 of 43 poses, without readings of the arm within 0.02 s before and after" in shown
    assert "1 messages of /joint_states that lack a joint of the robot" in shown
    assert "velocities of /joint_states (not all messages have them)" in shown
    assert "qd_" not in (tmp_path / "set" / "poses.csv").read_text("utf-8").splitlines()[0]


def test_fewer_measurements_may_be_taken(tmp_path):
    with recorder(tmp_path, "mcap") as (path, record):
        motion_capture(record)
    dataset = read([path], ImportOptions(robot=robolaser.find_robot(ARM), further={**BODY, "every_s": "1"}))
    assert np.diff(dataset.poses.time_s).min() >= 1
    assert len(dataset.poses) == 6


@pytest.mark.parametrize(
    ("left_out", "more", "expected"),
    [
        (
            ["poses"],
            {},
            r"what was measured\? State it with --set images=TOPIC \(there are none\), --set poses=TOPIC \(/mocap",
        ),
        (["mount"], {}, "--set mount=flange"),
        (["tolerance_s"], {}, "--set tolerance_s"),
        ([], {"poses": "/mocap/boddy"}, "no topic /mocap/boddy of type PoseStamped. Did you mean '/mocap/body'"),
        ([], {"joints": "/states"}, "no topic /states of type JointState"),
        ([], {"every_s": "often"}, "--set every_s=often"),
        ([], {"stamps": "sent"}, "--set stamps=sent: expected received"),
        ([], {"marker": "tag"}, "--set marker and --set poses: import one measurement after the other"),
    ],
)
def test_what_a_bag_leaves_open_is_asked_for(left_out, more, expected, tmp_path):
    with recorder(tmp_path, "mcap") as (path, record):
        motion_capture(record)
    stated = {key: value for key, value in {**BODY, **more}.items() if key not in left_out}
    with pytest.raises((UsageError, DataError), match=expected):
        read([path], ImportOptions(robot=robolaser.find_robot(ARM), further=stated))


def test_frames_of_tf_are_asked_for_and_sought(tmp_path):
    with recorder(tmp_path, "bag") as (path, record):
        frames(record, cell("base"))
        record.frame(START_S, "elsewhere", "island", np.eye(4))
    for key, expected in (
        ("base", "--set base=FRAME"),
        ("flange", "--set flange=FRAME"),
        ("camera", "--set camera=FRAME"),
    ):
        with pytest.raises(UsageError, match=expected):
            read([path], ImportOptions(further={one: value for one, value in MARKER.items() if one != key}))
    with pytest.raises(DataError, match=r"has no frame tool1 in tf\. Did you mean 'tool0'"):
        read([path], ImportOptions(further={**MARKER, "flange": "tool1"}))
    with pytest.raises(DataError, match="camera and island are in separate trees"):
        read([path], ImportOptions(further={**MARKER, "marker": "island"}))


def test_messages_without_stamps_take_the_recorders_times_where_that_is_said(tmp_path):
    made = cell("base")
    with recorder(tmp_path, "db3") as (path, record):
        record.header = lambda time_s, frame="": type(record).header(record, 0.0, frame)
        frames(record, made)
    with pytest.raises(DataError, match=r"have no time stamps.*--set stamps=received"):
        read([path], ImportOptions(further=MARKER))
    assert len(read([path], ImportOptions(further={**MARKER, "stamps": "received"})).poses) == 20


def test_a_motion_that_is_none_is_named(tmp_path):
    with recorder(tmp_path, "mcap") as (path, record):
        motion_capture(record)
        broken = np.eye(4)
        broken[0, 3] = np.nan
        record.pose("/mocap/body", START_S + 5.0, broken)
    with pytest.raises(DataError, match=r"topic /mocap/body: its numbers are not all finite"):
        read([path], ImportOptions(robot=robolaser.find_robot(ARM), further=BODY))


PICTURE = np.random.default_rng(5).integers(0, 256, (6, 8, 3)).astype(np.uint8)
ENCODINGS = {
    "bgr8": PICTURE, "rgb8": PICTURE[..., ::-1], "bgra8": np.dstack([PICTURE, PICTURE[..., :1]]),
    "mono8": PICTURE[..., 0], "mono16": PICTURE[..., 0].astype(np.uint16) * 257,
}  # fmt: skip
CAMERA = {"mount": "flange", "tolerance_s": "0.02", "board": "checkerboard,7x6,10mm"}


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("kind", ["bag", "mcap"])
def test_images_become_files_with_the_readings_of_their_times(kind, encoding, tmp_path):
    robot = robolaser.find_robot(ARM)
    pixels = ENCODINGS[encoding]
    with recorder(tmp_path, kind) as (path, record):
        at = np.arange(0, 4, 0.01)
        for time, q, qd in zip(at, *moving(at), strict=True):
            record.joints(START_S + time, list(robot.joints), q, qd)
        for time in (1.0, 2.0, 3.004, 9.0):
            record.image("/camera/image_raw", START_S + time, pixels, encoding)
    importer = importer_for([path])
    options = ImportOptions(robot=robot, further=CAMERA)
    importer.check(options, [path])
    imported = importer.read([path], options)
    (tmp_path / "set").mkdir()
    imported.write(tmp_path / "set")
    dataset = robolaser.load(tmp_path / "set")
    assert dataset.kind == "camera"
    assert dataset.image_px == (8, 6)
    assert dataset.options.mount == "flange"
    np.testing.assert_allclose(dataset.poses.q, moving(np.array([1.0, 2.0, 3.004]))[0], atol=1e-4)
    assert "1 of 4 images" in " ".join(imported.left_out)
    for name in dataset.poses.image:
        seen = cv2.imread(str(tmp_path / "set" / name), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(seen, PICTURE if encoding in ("bgr8", "rgb8", "bgra8") else pixels)


@pytest.mark.parametrize(
    ("file", "data"),
    [
        ("cell.bag", b""),
        ("cell.bag", b"#ROSBAG V2.0\n" + b"\xff" * 200),
        ("cell.mcap", b"\x00" * 90),
        ("cell.db3", b"SQLite format 3\x00" * 9),
    ],
)
def test_a_damaged_bag_ends_with_its_name(file, data, tmp_path):
    pytest.importorskip("rosbags")
    (tmp_path / file).write_bytes(data)
    with pytest.raises(DataError, match=file):
        read([tmp_path / file], ImportOptions(further=MARKER))
