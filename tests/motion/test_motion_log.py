"""A log of a moving arm comes back from its folder as it was, and what is wrong with one is said where it is."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from moved_arms import urdf, written

import robolaser
from robolaser.errors import DataError, UsageError
from robolaser.motion.checking import check_motion
from robolaser.motion.diagnosis import diagnose_motion
from robolaser.motion.log import QUANTITIES, MotionLog
from robolaser.motion.plan import plan_motion
from robolaser.motion.reading import load_motion
from robolaser.motion.simulation import simulate_motion
from robolaser.robot.kinematics import Robot


@pytest.fixture(scope="module")
def log() -> MotionLog:
    robot = Robot.from_urdf(urdf(), flange="tool", gravity=(0.0, 0.0, -9.81))
    whole = simulate_motion(robot, series=2, seed=1)
    return whole.of_rows(np.arange(len(whole)) % 2000 < 60)


@pytest.fixture
def folder(log: MotionLog, tmp_path: Path) -> Path:
    return written(log, tmp_path)


def edited(folder: Path, change: Callable[[list[list[str]]], object]) -> Path:
    """A change of the table's cells, the header first."""
    rows = [line.split(",") for line in (folder / "motion.csv").read_text(encoding="utf-8").splitlines()]
    change(rows)
    (folder / "motion.csv").write_text("\n".join(map(",".join, rows)) + "\n", encoding="utf-8")
    return folder


def test_what_is_written_is_read_back(log: MotionLog, folder: Path) -> None:
    back = load_motion(folder)
    for name in (*QUANTITIES, "time_s"):
        assert np.allclose(getattr(back, name), getattr(log, name), rtol=0.0, atol=1e-8, equal_nan=True)
    assert (back.series, back.joints, back.torque_unit) == (log.series, log.joints, log.torque_unit)
    assert np.array_equal(back.run, log.run)


def test_what_the_recorder_said_is_kept(log: MotionLog, tmp_path: Path) -> None:
    told = replace(
        log, name='an "arm" 🤖', torque_unit="A", torque_signed=False, offset_per_series=True,
        encoder_step_rad=1e-3, payload_kg={"run_1": 2.5},
    )  # fmt: skip
    back = load_motion(written(told, tmp_path))
    assert (back.name, back.torque_unit, back.torque_signed) == (told.name, "A", False)
    assert back.offset_per_series
    assert (back.encoder_step_rad, dict(back.payload_kg)) == (1e-3, {"run_1": 2.5})


def test_the_package_loads_it_as_it_loads_poses(folder: Path) -> None:
    assert isinstance(robolaser.load(folder), MotionLog)


def test_an_empty_cell_is_no_reading(folder: Path) -> None:
    def empty(rows: list[list[str]]) -> None:
        rows[3][rows[0].index("q_lift")] = ""

    back = load_motion(edited(folder, empty))
    assert np.isnan(back.q[2, 1])
    assert np.isfinite(back.q[2, 0])


def test_rows_of_a_series_need_not_stand_together(log: MotionLog, folder: Path) -> None:
    def mixed(rows: list[list[str]]) -> None:
        body = rows[1:]
        rows[1:] = [row for pair in zip(body[:60], body[60:], strict=True) for row in pair]

    assert np.allclose(load_motion(edited(folder, mixed)).q, log.q)


def test_a_repeated_stamp_is_left_out_and_said(log: MotionLog, folder: Path) -> None:
    back = load_motion(edited(folder, lambda rows: rows.insert(6, list(rows[5]))))
    assert len(back) == len(log)
    assert any("1 rows repeat" in warning or "1 row" in warning for warning in back.warnings)


def in_degrees(rows: list[list[str]]) -> None:
    column = rows[0].index("q_lift")
    for row in rows[1:]:
        row[column] = str(float(row[column]) * 180.0 / np.pi)


def of_no_joint(rows: list[list[str]]) -> None:
    rows[0] = [cell.replace("q_", "angle_") for cell in rows[0]]


BROKEN = {
    "time that goes back": (lambda rows: rows[7].__setitem__(1, "0.0"), (8, "time_s")),
    "a word for a number": (lambda rows: rows[4].__setitem__(rows[0].index("tau_pan"), "off"), (5, "tau_pan")),
    "degrees": (in_degrees, (None, "q_lift")),
    "no joint of the robot": (of_no_joint, None),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_table_is_refused_at_its_cell(folder, case):
    change, place = BROKEN[case]
    with pytest.raises(DataError) as caught:
        load_motion(edited(folder, change))
    assert place is None or (caught.value.row, caught.value.column) == place


def with_readings(log: MotionLog, pan: np.ndarray) -> MotionLog:
    return replace(log, q=np.column_stack([pan, log.q[:, 1:]]))


WRONG = {
    "Are these milliseconds": lambda log: replace(log, time_s=1e3 * log.time_s),
    "torque_unit": lambda log: replace(log, torque_unit="mNm"),
    "no series 'run_9'": lambda log: replace(log, payload_kg={"run_9": 1.0}),
    r"payload_kg\.\w+: .*, expected a number, 0 or more": lambda log: replace(log, payload_kg={log.series[0]: -1.0}),
}


@pytest.mark.parametrize("said", WRONG)
def test_what_no_recorder_can_have_measured_is_refused(log, tmp_path, said):
    with pytest.raises(DataError, match=said):
        load_motion(written(WRONG[said](log), tmp_path))


def test_noise_that_nothing_would_read_is_refused(folder: Path) -> None:
    with (folder / "dataset.toml").open("a", encoding="utf-8") as file:
        file.write("\n[noise]\njoint_step_rad = 1e-3\n")
    with pytest.raises(DataError, match=r"dataset.toml.* noise: this key is not known"):
        load_motion(folder)


def test_odd_readings_are_said_to_be_what_they_are(log: MotionLog, tmp_path: Path) -> None:
    pan = log.command[:, 0]
    odd = {"sign": -pan, "digit by digit": pan, "does not move": np.full_like(pan, 0.3), "degrees": pan * np.pi / 180.0}
    for said, values in odd.items():
        (warning,) = load_motion(written(with_readings(log, values), tmp_path)).warnings
        assert said in warning
    assert load_motion(written(log, tmp_path)).warnings == ()


def test_torques_of_several_joints_that_are_never_negative_have_no_sign(log: MotionLog) -> None:
    assert log.has_signs
    assert not replace(log, tau=np.abs(log.tau)).has_signs
    assert replace(log, tau=np.where(np.arange(len(log.joints)) == 1, np.abs(log.tau), np.nan)).has_signs
    assert replace(log, tau=np.where(log.tau > 0.0, 0.0, np.nan)).has_signs  # nobody knows of what sign zeros are


def test_a_pause_ends_a_stretch_but_not_its_run(log: MotionLog) -> None:
    late = replace(log, time_s=log.time_s + 5.0 * (np.arange(len(log)) % 60 >= 20))
    assert [(rows.stop - rows.start, int(late.run[rows.start])) for rows in late.stretches] == [
        (20, 0), (40, 0), (20, 1), (40, 1),
    ]  # fmt: skip
    assert log.stretches == log.rows_of_runs


def test_rows_in_which_the_arm_stands_show_no_torques_but_the_rest(log: MotionLog) -> None:
    count = 200
    rows = np.arange(2 * count)
    still = replace(
        log, run=rows // count, time_s=(rows % count) / 100.0,
        **{name: np.repeat(getattr(log, name)[[0, 60]], count, axis=0) for name in QUANTITIES},
    )  # fmt: skip
    still = replace(still, load=np.full_like(still.q, np.nan))
    assert check_motion(still).not_tested["coulomb_friction"] == "the arm stands still, or jerks, in all rows"
    assert plan_motion(still).untestable["coulomb_friction"] == "the arm stands still, or jerks, in all rows"
    found = diagnose_motion(still, ["offset", "coulomb_friction"])
    assert any("Torque rows are set aside: the arm stands" in remark for remark in found.remarks)
    assert any("commanded to stand still" in remark for remark in found.remarks)


def test_a_log_is_not_saved_as_poses(log: MotionLog, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="MotionLog"):
        robolaser.save(log, tmp_path / "out")


def test_readings_that_are_the_commands_are_no_arm_without_a_gap(log: MotionLog) -> None:
    echo = replace(log, q=log.command, tau=np.full_like(log.q, np.nan), load=np.full_like(log.q, np.nan))
    assert check_motion(echo).kinds == ()
    with pytest.raises(DataError, match="the readings are the commands, digit by digit"):
        diagnose_motion(echo)


def test_further_keys_are_written_and_read_back(log: MotionLog, tmp_path: Path) -> None:
    notes = {"rate_hz": 100, "encoder_side": "motor", "tools": ["gripper"]}
    assert load_motion(written(replace(log, notes=notes), tmp_path)).notes == notes


def test_times_count_from_the_beginning_of_each_series(log: MotionLog, tmp_path: Path) -> None:
    late = replace(log, time_s=log.time_s + 40.0 * (1 + log.run))
    assert np.allclose(load_motion(written(late, tmp_path)).time_s, log.time_s, rtol=0.0, atol=1e-6)


def test_commands_and_readings_that_are_never_in_one_row_are_said_to_be(log: MotionLog) -> None:
    odd = (np.arange(len(log)) % 2 == 1)[:, None]
    apart = replace(log, command=np.where(odd, log.command, np.nan), q=np.where(odd, np.nan, log.q))
    assert check_motion(apart).not_tested["lag"] == "no row has both a command and a reading of a joint"
