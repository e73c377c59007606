"""What is grossly wrong with files is said when they are imported, before anybody calibrates."""

from pathlib import Path

import numpy as np
import pytest

from robolaser.cli import main
from robolaser.data.stated_noise import Noise
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


def log(path: Path, unit_m: float, exchanged: tuple[int, int] | None = None) -> Path:
    made = simulate(find_robot("ur5"), kind="point", poses=20, points=1, noise=Noise(point_m=3e-5), seed=1).dataset
    robot, q = made.arm
    xyz = np.array(made.points.xyz) / unit_m
    if exchanged:
        xyz[list(exchanged)] = xyz[list(exchanged)[::-1]]
    lines = [",".join([*robot.joints, "x", "y", "z"])]
    lines += [",".join(repr(float(value)) for value in (*joints, *place)) for joints, place in zip(q, xyz, strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def imported(path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    asked = ["--robot", "ur5", "--units", "m,rad", "--ordered", "--point", "P", "--output", str(path.parent / "cell")]
    assert main(["import", str(path), *asked]) == 0
    return capsys.readouterr().err


def test_points_in_inches_are_noticed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "The points seem to be in inches" in imported(log(tmp_path / "log.csv", 0.0254), capsys)


def test_points_of_two_poses_that_are_exchanged_are_noticed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "are exchanged. Correct the data set." in imported(log(tmp_path / "log.csv", 1.0, (7, 16)), capsys)


def test_sound_files_are_imported_without_a_word(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = imported(log(tmp_path / "log.csv", 1.0), capsys)
    assert "seem" not in said
    assert "exchanged" not in said


def test_a_name_that_looks_like_a_number_is_shown_as_it_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, joints = tmp_path / "log.csv", find_robot("ur5").joints
    path.write_text(f"pose,point,x_m,y_m,z_m,{','.join(joints)}\n1.10,a,0.1234567,0,0,0,0,0,0,0,0\n", encoding="utf-8")
    asked = ["--robot", "ur5", "--units", "m,rad", "--ordered", "--output", str(tmp_path / "cell"), "--dry-run"]
    assert main(["import", str(path), *asked]) == 0
    shown = capsys.readouterr().out
    assert " 1.10\n" in shown
    assert " 0.123457\n" in shown
