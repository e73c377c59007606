"""Bags of ROS become logs of moving arms: readings with the command that held at each of them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import FORMATS, START_S, recorder

from robolaser.cli import main
from robolaser.data.importers import ImportOptions
from robolaser.data.importers.robots import find_robot
from robolaser.motion.importing import import_motion
from robolaser.motion.log import MotionLog

ROBOT = find_robot("scorbot_er7")
JOINTS = list(ROBOT.joints)
CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
POINT = "trajectory_msgs/msg/JointTrajectoryPoint"
STATE = f"std_msgs/Header header\nstring[] joint_names\n{POINT} reference\n{POINT} feedback\n"


def angles(time_s: float) -> np.ndarray:
    """Where the joints are [rad]."""
    return 0.3 * np.sin(time_s + np.arange(len(JOINTS)))


def command(number: int) -> np.ndarray:
    """The one that is sent every 0.1 s."""
    return angles(0.1 * number) + 0.05


def log_of(path: Path, **further: str) -> MotionLog:
    return import_motion([path], ROBOT, ImportOptions(further=further))[0]


def readings(bag: Any, *, topic: str = "/joint_states", until: float = 2.0) -> None:
    for i in range(round(until / 0.02)):
        bag.joints(START_S + 0.02 * i, JOINTS, angles(0.02 * i), np.zeros(len(JOINTS)), topic)


@pytest.mark.parametrize("kind", FORMATS)
def test_each_reading_has_the_command_that_was_sent_last(tmp_path: Path, kind: str) -> None:
    with recorder(tmp_path, kind) as (path, bag):
        readings(bag)
        for i in range(1, 20):
            bag.joints(START_S + 0.1 * i - 0.01, JOINTS, command(i), np.empty(0), "/joint_commands")
    log = log_of(path, joints="/joint_states", commands="/joint_commands")
    assert len(log) == 100
    assert np.allclose(log.q, [angles(t) for t in log.time_s], atol=1e-6)
    sent = np.floor((log.time_s + 0.01 + 1e-6) / 0.1).astype(int)
    assert np.isnan(log.command[sent < 1]).all()
    assert np.allclose(log.command[sent >= 1], [command(i) for i in np.minimum(sent[sent >= 1], 19)])


def test_a_controllers_state_is_command_and_reading(tmp_path: Path) -> None:
    with recorder(tmp_path, "mcap") as (path, bag):
        from rosbags.typesys import get_types_from_msg  # noqa: PLC0415 - an extra

        bag.store.register(get_types_from_msg(STATE, CONTROLLER))
        kinds = bag.store.types
        nothing, still = np.empty(0), kinds["builtin_interfaces/msg/Duration"](0, 0)
        for i in range(50):
            told, read = (kinds[POINT](q, nothing, nothing, nothing, still) for q in (command(i), angles(0.1 * i)))
            header = bag.header(START_S + 0.1 * i)
            bag.write("/arm/controller_state", CONTROLLER, START_S + 0.1 * i, header, JOINTS, told, read)
    log = log_of(path)
    assert np.allclose(log.q, [angles(t) for t in log.time_s], atol=1e-6)
    assert np.allclose(log.command, [command(i) for i in range(50)])


def test_commands_without_a_time_of_their_own_count_from_when_they_were_recorded(tmp_path: Path) -> None:
    with recorder(tmp_path, "db3") as (path, bag):
        readings(bag)
        layout = bag.store.types["std_msgs/msg/MultiArrayLayout"]([], 0)
        for i in range(20):
            bag.write("/commands", "std_msgs/msg/Float64MultiArray", START_S + 0.1 * i, layout, command(i))
    log = log_of(path)
    read_s = log.time_s + 0.002  # the bag's recorder is late by so much
    sent = np.floor((read_s + 1e-6) / 0.1).astype(int)
    assert np.allclose(log.command, [command(i) for i in sent])


def test_a_pause_begins_another_series(tmp_path: Path) -> None:
    with recorder(tmp_path, "mcap") as (path, bag):
        readings(bag)
        for i in range(50):
            bag.joints(START_S + 10.0 + 0.02 * i, JOINTS, angles(0.02 * i), np.empty(0))
    assert len(log_of(path).series) == 2


def test_several_topics_of_readings_are_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with recorder(tmp_path, "mcap") as (path, bag):
        readings(bag)
        readings(bag, topic="/other_states")
    asked = ["--robot", "scorbot_er7", "--sensor", "motion", "--output", str(tmp_path / "log")]
    assert main(["import", str(path), *asked]) == 2
    assert "--set joints=TOPIC" in capsys.readouterr().err
    assert main(["import", str(path), *asked, "--set", "joints=/joint_states", "--quiet"]) == 0
