"""A table of Denavit and Hartenberg's numbers becomes the arm that the product of its matrices says."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robolaser.data.importers.robots import find_robot
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import pose, rot_x, rot_z
from robolaser.robot.kinematics import Robot

Row = Mapping[str, Any]
# UR5, the numbers of its maker
UR5 = [
    {"a": 0.0, "alpha": np.pi / 2, "d": 0.089159, "theta": 0.0, "lower": -6.0, "upper": 6.0},
    {"a": -0.425, "alpha": 0.0, "d": 0.0, "theta": 0.0},
    {"a": -0.39225, "alpha": 0.0, "d": 0.0, "theta": 0.0},
    {"a": 0.0, "alpha": np.pi / 2, "d": 0.10915, "theta": 0.0},
    {"a": 0.0, "alpha": -np.pi / 2, "d": 0.09465, "theta": 0.0},
    {"a": 0.0, "alpha": 0.0, "d": 0.0823, "theta": 0.0},
]
TURN = {"lower": -3.0, "upper": 3.0, "mass_kg": 2.0, "com_x": 0.1, "com_y": 0.02, "com_z": -0.03}
SLIDE = {"kind": "prismatic", "lower": -0.5, "upper": 0.5, "mass_kg": 1.5, "com_y": 0.05, "com_z": 0.2}
ODD = [
    {"name": "stand", "a": 0.1, "alpha": 0.3, "d": 0.4, "theta": 0.5, "kind": "fixed"},
    {"name": "turn", "a": 0.2, "alpha": -0.7, "d": 0.05, "theta": 1.1, **TURN},
    {"name": "slide", "a": -0.1, "alpha": 0.9, "d": 0.3, "theta": -0.4, **SLIDE},
    {"name": "roll", "a": 0.05, "alpha": 0.2, "d": 0.1, "theta": 0.2},
    {"name": "tool", "a": 0.0, "alpha": 0.1, "d": 0.15, "theta": 0.3, "kind": "fixed"},
]
PLAIN = {"name": "a", "a": 0, "alpha": 0, "d": 0.1, "theta": 0}


def arm(folder: Path, rows: Sequence[Row], convention: str = "standard") -> Robot:
    lines = [line for row in rows for line in ("[[joint]]", *(f"{key} = {value!r}" for key, value in row.items()))]
    tables = "\n".join(lines or ["joint = []"])
    (folder / "arm.toml").write_text(f'convention = "{convention}"\nunits = "m,rad"\n{tables}', "utf-8")
    return find_robot(folder / "arm.toml")


def product(rows: Sequence[Row], convention: str, q: np.ndarray) -> list[np.ndarray]:
    """The frame of each row, by the matrices of the textbooks."""
    T, frames, readings = np.eye(4), [], iter(q)
    for row in rows:
        kind = row.get("kind", "revolute")
        reading = 0.0 if kind == "fixed" else next(readings)
        theta = row["theta"] + (reading if kind == "revolute" else 0.0)
        d = row["d"] + (reading if kind == "prismatic" else 0.0)
        screw_x = pose(rot_x(np.array(row["alpha"])), np.array([row["a"], 0, 0]))
        screw_z = pose(rot_z(np.array(theta)), np.array([0, 0, d]))
        T = T @ (screw_z @ screw_x if convention == "standard" else screw_x @ screw_z)
        frames.append(T)
    return frames


@pytest.mark.parametrize("convention", ["standard", "modified"])
@pytest.mark.parametrize("rows", [UR5, ODD], ids=["ur5", "odd"])
def test_the_flange_is_where_the_product_of_the_matrices_says(rows: list[Row], convention: str, tmp_path: Path) -> None:
    robot = arm(tmp_path, rows, convention)
    q = np.random.default_rng(1).uniform(-0.5, 0.5, (20, len(robot.joints)))
    expected = [product(rows, convention, row)[-1] for row in q]
    np.testing.assert_allclose(robot.forward(q[None])[0], expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_its_weight_hangs_where_the_rows_frames_say(convention: str, tmp_path: Path) -> None:
    def energy(q: np.ndarray) -> float:
        centres = [[*(row.get(f"com_{axis}", 0.0) for axis in "xyz"), 1.0] for row in ODD]
        frames = product(ODD, convention, q)
        return sum(
            9.81 * row.get("mass_kg", 0.0) * (T @ com)[2] for row, com, T in zip(ODD, centres, frames, strict=True)
        )

    q, step = np.array([0.3, 0.1, -0.4]), 1e-6
    slopes = [(energy(q + step * e) - energy(q - step * e)) / (2 * step) for e in np.eye(3)]
    robot = arm(tmp_path, ODD, convention)
    np.testing.assert_allclose(robot.gravity_torques(q[None])[0], slopes, rtol=0, atol=1e-7)


def test_joints_and_limits_are_those_of_the_table(tmp_path: Path) -> None:
    assert arm(tmp_path, ODD).joints == ("turn", "slide", "roll")
    robot = arm(tmp_path, UR5)
    assert robot.lower.tolist() == [-6.0] + [-np.inf] * 5
    assert robot.upper.tolist() == [6.0] + [np.inf] * 5


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([], "no joint that moves"),
        ([{**PLAIN, "kind": "fixed"}], "no joint that moves"),
        ([PLAIN, PLAIN], "two joints named 'a'"),
        ([{**PLAIN, "kind": "prismatic"}], "'a' slides without limits"),
        ([{**PLAIN, "lower": -1.0}], "'a' has one limit only. State its lower and upper limit"),
        ([{**PLAIN, "lower": 1.0, "upper": -1.0}], "lower limit 1 above its upper limit -1"),
        ([{**PLAIN, "mass_kg": -3.0}], "row 1, column mass_kg: -3, expected zero or more"),
        ([PLAIN, {**PLAIN, "name": "t", "kind": "fixed", "mass_kg": 1.0}], "row 2 is fixed and has a mass"),
    ],
)
def test_a_table_that_is_no_arm_is_refused_with_the_reason(rows: list[Row], said: str, tmp_path: Path) -> None:
    with pytest.raises(RobotError, match=said):
        arm(tmp_path, rows)
