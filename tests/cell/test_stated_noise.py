"""How finely joints were read is stated, however the cell's file is written."""

import tomllib

import numpy as np
import pytest

from robolaser.cell.recording_writer import quantization_rad, with_noise
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot

LINE = "joint_rad = 0.00029"


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[noise]\n",
        "[noise]",
        "[ noise ]  # a comment\npixel_px = 0.1\n[board]\ncolumns = 9\n",
        '["noise"]\npixel_px = 0.1\n',
        "name = 'x'\r\n[noise]\r\npixel_px = 0.1\r\n",
    ],
)
def test_a_line_is_put_where_it_belongs_and_nothing_else_changes(text: str) -> None:
    said, before = tomllib.loads(with_noise(text, 2.9e-4)), tomllib.loads(text)
    assert said["noise"].pop("joint_rad") == 2.9e-4
    assert {"noise": {}, **before} == said


@pytest.mark.parametrize("text", ["noise = {}\n", "noise = { pixel_px = 0.1 }\n", "noise.pixel_px = 0.1\n"])
def test_where_there_is_no_room_for_it_that_is_said(text: str) -> None:
    assert with_noise(text, 2.9e-4) is None


@pytest.mark.parametrize("text", ["[noise]\njoint_rad = 3e-5\n", "noise = { joint_rad = 3e-5 }\n"])
def test_what_the_cell_states_is_kept(text: str) -> None:
    assert with_noise(text, 2.9e-4) == text


def test_only_joints_that_turn_have_a_noise_in_radians() -> None:
    urdf = find_robot("scorbot_er7").urdf
    first = urdf.index('type="revolute"')
    rail = Robot.from_urdf(urdf[:first] + 'type="prismatic"' + urdf[first + len('type="revolute"') :], flange="flange")
    step = np.where(rail.prismatic, 0.5, 1e-3)
    assert rail.prismatic.sum() == 1
    assert quantization_rad(step, rail) == pytest.approx(1e-3 / np.sqrt(12))
