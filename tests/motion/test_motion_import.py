"""Logs that other programs wrote become data sets, each column where it belongs, in radians and seconds."""

import json
import os
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from moved_arms import JOINTS, urdf
from scipy.io import savemat

import robolaser
from robolaser.cli import main
from robolaser.data.importers.importer import ImportOptions
from robolaser.motion.importing import import_motion
from robolaser.motion.log import MotionLog
from robolaser.robot.kinematics import Robot

DATA = Path(os.environ.get("ROBOLASER_DATA", "nowhere"))
TIME = np.arange(40) / 50.0
READ = np.column_stack([np.sin(TIME + j) for j in range(4)])
TOLD = READ + 0.01


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "arm.urdf").write_text(urdf(), encoding="utf-8")
    return tmp_path


def typed(folder: Path, source: str, *more: str) -> int:
    asked = ["--robot", str(folder / "arm.urdf"), "--flange", "tool", "--sensor", "motion", "--quiet"]
    return main(["import", str(folder / source), *asked, *more, "--output", str(folder / "log")])


def imported(folder: Path, source: str, *more: str) -> MotionLog:
    assert typed(folder, source, *more) == 0
    return robolaser.load(folder / "log")


def test_a_table_with_any_names(folder):
    names = ["ms", *(f"goal{j}" for j in range(4)), *(f"is{j}" for j in range(4))]
    table = np.column_stack([1e3 * TIME, np.degrees(TOLD), np.degrees(READ)])
    np.savetxt(folder / "log.csv", table, delimiter=",", header=",".join(names), comments="", fmt="%.12g")
    columns = [f"q_{joint}=is{j}" for j, joint in enumerate(JOINTS)] + [
        f"command_{joint}=goal{j}" for j, joint in enumerate(JOINTS)
    ]
    stated = [word for column in [*columns, "time_s=ms"] for word in ("--column", column)]
    log = imported(folder, "log.csv", *stated, "--units", "deg,ms")
    assert np.allclose(log.q, READ)
    assert np.allclose(log.command, TOLD)
    assert np.allclose(log.time_s, TIME)


@pytest.mark.parametrize("kind", ["npz", "mat"])
def test_arrays_in_the_robots_order(folder, kind):
    arrays = {"t": TIME, "position": READ, "target": TOLD}
    if kind == "npz":
        np.savez(folder / "log.npz", **arrays)
    else:
        savemat(folder / "log.mat", arrays)
    log = imported(folder, f"log.{kind}", "--column", "q=position", "--column", "command=target", "--units", "rad")
    assert np.allclose(log.q, READ)
    assert np.allclose(log.command, TOLD)


@pytest.mark.parametrize("wrap", [list, lambda names: {"motors": names}], ids=["version 3", "version 2"])
def test_a_data_set_of_lerobot(folder, wrap):
    names = [f"{joint}.pos" for joint in JOINTS]
    feature = {"names": wrap(names)}
    (folder / "set" / "meta").mkdir(parents=True)
    (folder / "set" / "data" / "chunk-000").mkdir(parents=True)
    (folder / "set" / "meta" / "info.json").write_text(
        json.dumps({"features": {"action": feature, "observation.state": feature}}), encoding="utf-8"
    )
    table = {
        "action": np.degrees(TOLD).tolist(),
        "observation.state": np.degrees(READ).tolist(),
        "timestamp": np.concatenate([TIME[:20], TIME[:20]]),
        "episode_index": np.repeat([0, 1], 20),
    }
    pq.write_table(pa.table(table), folder / "set" / "data" / "chunk-000" / "episode_000000.parquet")
    log = imported(folder, "set", "--units", "deg")
    assert len(log.series) == 2
    assert np.allclose(log.q, READ)
    assert np.allclose(log.command, TOLD)


@pytest.mark.parametrize("row", ["1,[0]", "1,0]", "1", '1,{"pan": 0}'])
@pytest.mark.parametrize("of", ["positions", "angles"])
def test_a_damaged_folder_ends_with_its_name(folder, row, of, capsys):
    files = {"joint_list.txt": "pan", "control.csv": f"timestamp,{of}\n{row}", "state_motor.csv": f"timestamp,q\n{row}"}
    (folder / "log-a" / "meta").mkdir(parents=True)
    for name, text in files.items():
        (folder / "log-a" / name).write_text(text, encoding="utf-8")
    assert typed(folder, "log-a") == 1
    assert "log-a is damaged" in capsys.readouterr().err
    for info in ("{", "[]", '{"features": null}', '{"features": {"action": {"names": 3}}}'):
        (folder / "log-a" / "meta" / "info.json").write_text(info, encoding="utf-8")
        assert typed(folder, "log-a") == 1
        assert "log-a is damaged" in capsys.readouterr().err


def test_a_unit_that_no_file_says_is_asked_for(folder, capsys):
    np.savez(folder / "log.npz", t=TIME, position=READ)
    assert typed(folder, "log.npz", "--column", "q=position") == 2
    assert "--units deg" in capsys.readouterr().err
    assert not (folder / "log").exists()


def test_a_column_that_is_not_there_is_answered_with_the_nearest(folder, capsys):
    np.savez(folder / "log.npz", t=TIME, position=READ)
    assert typed(folder, "log.npz", "--units", "rad", "--column", "q=positon") == 1
    assert "position[0]" in capsys.readouterr().err


def test_a_table_of_universal_robots_rtde_says_its_units_itself(folder):
    arrays = {"timestamp": TIME + 17.0}
    for name, values in (("target_q", TOLD), ("actual_q", READ), ("actual_qd", 2.0 * READ), ("actual_current", -READ)):
        arrays |= {f"{name}_{j}": each for j, each in enumerate(values.T)}
    table = np.column_stack(list(arrays.values()))
    np.savetxt(folder / "robot_data.csv", table, header=" ".join(arrays), comments="", fmt="%.12g")
    log = imported(folder, "robot_data.csv")
    assert np.allclose(log.time_s, TIME)
    assert np.allclose(log.q, READ)
    assert np.allclose(log.command, TOLD)
    assert np.allclose(log.qd, 2.0 * READ)
    assert log.torque_unit == "A"


@pytest.mark.parametrize("unit", ["percent", "ticks"])
def test_lerobots_calibration_makes_angles_of_what_servos_count(folder, unit):
    ends = [(1000, 3000), (800, 3300), (1200, 2600), (900, 3100)]
    servos = {
        joint: {"id": j, "drive_mode": int(j == 2), "homing_offset": 5, "range_min": low, "range_max": high}
        for j, (joint, (low, high)) in enumerate(zip(JOINTS, ends, strict=True))
    }
    (folder / "my_arm.json").write_text(json.dumps(servos), encoding="utf-8")
    middle, half = (np.array([(high + side * low) / 2 for low, high in ends]) for side in (1, -1))
    side = np.array([1.0, 1.0, -1.0 if unit == "percent" else 1.0, 1.0])  # as LeRobot's `_normalize`
    turned = [side * values * 4096 / (2 * np.pi) for values in (READ, TOLD)]
    counted = [values + middle if unit == "ticks" else 100.0 * values / half for values in turned]
    np.savez(folder / "log.npz", t=TIME, position=counted[0], target=counted[1])
    of_arrays = ("--column", "q=position", "--column", "command=target", "--units", unit)
    log = imported(folder, "log.npz", *of_arrays, "--set", f"calibration={folder / 'my_arm.json'}")
    assert np.allclose(log.q, READ)
    assert np.allclose(log.command, TOLD)


def test_per_cent_without_a_calibration_file_is_asked_for(folder, capsys):
    np.savez(folder / "log.npz", t=TIME, position=READ)
    assert typed(folder, "log.npz", "--column", "q=position", "--units", "percent") == 2
    assert "--set calibration=FILE" in capsys.readouterr().err


@pytest.mark.skipif(not (DATA / "raw-sage").is_dir(), reason="published logs are not on this machine")
def test_sages_own_files_are_read_as_they_were_published(tmp_path):
    whole = robolaser.load(DATA / "sage-so101-a")
    arm = ["--robot", str(DATA / "sage-so101-a" / "robot.urdf"), "--flange", "gripper_frame_link"]
    asked = [str(DATA / "raw-sage"), *arm, "--sensor", "motion", "--output", str(tmp_path / "log"), "--quiet"]
    assert main(["import", *asked]) == 0
    log = robolaser.load(tmp_path / "log")
    rows = whole.rows_of_runs[whole.series.index("triangle_wave")]
    assert log.series == ("triangle_wave",)
    assert not log.torque_signed
    for name in ("q", "command", "tau"):
        assert np.allclose(getattr(log, name), getattr(whole, name)[rows], atol=1e-6)
    assert isinstance(log.robot, Robot)
    assert np.allclose(log.time_s, whole.time_s[rows], atol=1e-5)


def test_series_that_would_share_a_name_stay_apart(folder):
    columns = {f"q_{joint}": READ[:, j] for j, joint in enumerate(JOINTS)}
    for day in ("monday", "tuesday"):
        (folder / day).mkdir()
        np.savez(folder / day / "log.npz", time_s=TIME, **columns)
    arm = Robot.from_urdf(urdf(), flange="tool")
    sources = [folder / day / "log.npz" for day in ("monday", "tuesday")]
    log, _ = import_motion(sources, arm, ImportOptions(robot=arm, units=("rad",)))
    assert (len(log), log.series) == (2 * len(TIME), ("log", "log_2"))


def test_series_that_are_numbered_by_large_numbers_stay_apart(folder):
    both = {f"q_{joint}": np.tile(READ[:, j], 2) for j, joint in enumerate(JOINTS)}
    begun = np.repeat([1_700_000_001, 1_700_000_002], len(TIME))
    np.savez(folder / "log.npz", time_s=np.tile(TIME, 2), series=begun, **both)
    assert imported(folder, "log.npz", "--units", "rad").series == ("log_1700000001", "log_1700000002")


@pytest.mark.parametrize("column", ["series", "time_s"])
def test_a_row_without_a_series_or_a_time_is_refused(folder, capsys, column):
    columns = {"time_s": TIME.copy(), "series": np.ones(len(TIME))}
    columns |= {f"q_{joint}": READ[:, j] for j, joint in enumerate(JOINTS)}
    columns[column][7] = np.nan
    np.savez(folder / "log.npz", **columns)
    assert typed(folder, "log.npz", "--units", "rad") == 1
    assert "row 8" in capsys.readouterr().err
    assert not (folder / "log").exists()


def test_series_keep_their_names_in_tables(folder):
    columns = {"time_s": np.tile(TIME, 2), **{f"q_{joint}": np.tile(READ[:, j], 2) for j, joint in enumerate(JOINTS)}}
    days = pa.table({"series": np.repeat(["läuft", "am 2."], len(TIME)), "dt": np.repeat(0.02, 80), **columns})
    pq.write_table(days, folder / "log.parquet")
    lines = [",".join(map(str, row.values())) for row in days.to_pylist()]
    (folder / "log.csv").write_text("\r\n".join([",".join(days.column_names), *lines]), encoding="utf-8-sig")
    for name in ("log.parquet", "log.csv"):
        log = imported(folder, name, "--units", "rad", "--force")
        assert log.series == ("log_läuft", "log_am 2.")
        assert np.allclose(log.q, np.tile(READ, (2, 1)))


READINGS = {f"q_{joint}": READ[:, j] for j, joint in enumerate(JOINTS)}


@pytest.mark.parametrize(
    ("arrays", "more", "said"),
    [
        ({"time_s": TIME[:0], **{name: each[:0] for name, each in READINGS.items()}}, [], "has no times"),
        ({"time_s": TIME[1:], **READINGS}, [], "column q_pan: it has not as many rows as there are times"),
        ({"time_s": TIME, "series": np.ones(39), **READINGS}, [], "series 'log_1' has no times"),
        ({"time_s": TIME, **READINGS, "q_lift": READ[:, 1].astype(str), "q_pan": np.repeat("off", 40)}, [], "'off'"),
        ({"time_s": TIME, **READINGS}, ["--column", "q_pann=q_pan"], "Did you mean 'q_pan'?"),
        ({"time_s": TIME, **READINGS}, ["--column", "series=episode"], "no column 'episode'"),
        ({"time_s": TIME[::-1], **READINGS}, [], "column time_s"),
        ({"time_s": TIME, **{name: 99.0 * each for name, each in READINGS.items()}}, [], "Are these degrees"),
    ],
)
def test_what_would_be_no_log_is_not_written(folder, arrays, more, said, capsys):
    np.savez(folder / "log.npz", **arrays)
    assert typed(folder, "log.npz", "--units", "rad", *more) != 0
    assert said in capsys.readouterr().err
    assert not (folder / "log").exists()


def test_a_scalar_beside_the_columns_is_of_no_series(folder):
    np.savez(folder / "log.npz", time_s=TIME, series=np.repeat([1, 2], 20), dt=[0.02], **READINGS)
    assert imported(folder, "log.npz", "--units", "rad").series == ("log_1", "log_2")
