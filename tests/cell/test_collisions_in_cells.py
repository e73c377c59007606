"""What a cell's arm would hit is said before anything moves."""

from pathlib import Path

import bench
import numpy as np
import pytest
from emulated_cell import cell_folder

from robolaser.cell.plan_validation import FINE, RouteCheck
from robolaser.cell.route import numbered
from robolaser.cli import main
from robolaser.data.cell_config import load_cell
from robolaser.errors import PlanError, RobolaserError

POST = """[[box]]
name = "post"
centre_m = [0.35, 0.2, 0.3]
size_m = [0.05, 0.05, 0.6]
"""
LEFT, RIGHT = np.array([0.1, -0.4, 0.6, 0.0, 0.0]), np.array([0.95, -0.4, 0.6, 0.0, 0.0])
INTO = np.array([0.52, -0.4, 0.6, 0.0, 0.0])


def with_post(tmp_path: Path, text: str = POST) -> Path:
    folder = cell_folder(tmp_path)
    with (folder / "cell.toml").open("a") as file:
        file.write(text)
    return folder


def test_pose_bodies_and_depth_are_said_and_the_way_is_looked_at(tmp_path: Path) -> None:
    cell = load_cell(with_post(tmp_path))
    assert not RouteCheck.of(cell).violations(LEFT, ["left"], LEFT[None])
    at_pose = RouteCheck.of(cell).violations(None, ["into"], INTO[None])
    assert any(one.startswith("into: link_3 and post overlap by ") for one in at_pose), at_pose
    on_the_way = RouteCheck.of(cell).violations(LEFT, ["right"], RIGHT[None])
    assert on_the_way
    assert all(one.startswith("on the way to right: ") and "post" in one for one in on_the_way)


def test_a_body_nearer_than_the_margin_is_refused_and_none_slips_between_two_steps(tmp_path: Path) -> None:
    """Between postures FINE apart a point at 0.6 m moves by less than the margin, however thin what it passes."""
    cell = load_cell(with_post(tmp_path, POST.replace("[0.05, 0.05, 0.6]", "[0.0005, 0.0005, 0.6]")))
    assert cell.limits.margin_m > FINE * 0.6 / 2
    assert RouteCheck.of(cell).violations(LEFT, ["right"], RIGHT[None])
    line = LEFT + np.linspace(0, 1, 200)[:, None] * (RIGHT - LEFT)
    nearest = RouteCheck.of(cell).bodies.gaps(line).min(axis=1)
    beside = line[np.flatnonzero((nearest > 0) & (nearest < cell.limits.margin_m))[0]]
    (found,) = RouteCheck.of(cell).violations(None, ["p"], beside[None])
    assert found.endswith("mm apart, limit 10 mm (margin_m)")


def test_a_dry_run_and_a_recording_refuse_and_nothing_moves(tmp_path: Path, capsys) -> None:
    folder = with_post(tmp_path)
    rows = [",".join(map(str, q)) for q in (LEFT, RIGHT)]
    (tmp_path / "poses.csv").write_text("q_joint_1,q_joint_2,q_joint_3,q_joint_4,q_joint_5\n" + "\n".join(rows) + "\n")
    asked = ["record", str(folder), "--poses", str(tmp_path / "poses.csv"), "--output", str(tmp_path / "out")]
    assert main([*asked, "--dry-run"]) == 1
    said = capsys.readouterr().err
    assert "on the way to p002: link_3 and post overlap by" in said
    assert "[[box]]" in said
    cell = load_cell(folder)
    rig = bench.bench_for(cell)
    before = rig.motor().copy()
    writer = bench.begun(cell, tmp_path / "rec", numbered(np.array([LEFT, RIGHT])))
    with pytest.raises(PlanError, match="and post overlap"):
        bench.session(cell, rig, writer).run(lambda _: None)
    np.testing.assert_array_equal(rig.motor(), before)


def test_a_box_that_the_arm_is_in_wherever_it_goes_is_refused(tmp_path: Path, capsys) -> None:
    folder = with_post(tmp_path, POST.replace("[0.05, 0.05, 0.6]", "[9.0, 9.0, 9.0]").replace("post", "hall"))
    (tmp_path / "poses.csv").write_text(
        f"q_joint_1,q_joint_2,q_joint_3,q_joint_4,q_joint_5\n{','.join(map(str, LEFT))}\n"
    )
    asked = ["record", str(folder), "--poses", str(tmp_path / "poses.csv"), "--output", str(tmp_path / "out")]
    assert main([*asked, "--dry-run"]) == 1
    assert "and hall overlap at every position of the arm" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (POST + 'link = "nowhere"', "No frame 'nowhere'"),
        (POST.replace("post", "link_2"), "a name that no other box and no link has"),
        (POST + POST, "a name that no other box"),
        (POST + "quat = [0, 0, 0, 2]", "has length 2, expected 1"),
        (POST.replace("0.6]", "-0.6]"), "size_m"),
    ],
)
def test_a_box_that_cannot_be_is_refused_by_its_key(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(RobolaserError, match=said) as caught:
        load_cell(with_post(tmp_path, text))
    assert "cell.toml" in str(caught.value)
