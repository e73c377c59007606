"""A table of Denavit and Hartenberg's numbers becomes the arm that the product of its matrices says."""

import numpy as np
import pytest

from robolaser.data.importers.robots.denavit_hartenberg import CONVENTIONS, Convention, DHRow, dh_urdf
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import pose, rot_x, rot_z
from robolaser.robot.kinematics import Robot

# UR5 and Panda, the numbers of their makers
UR5 = [
    DHRow("a", 0.0, np.pi / 2, 0.089159, 0.0, lower=-6.0, upper=6.0),
    DHRow("b", -0.425, 0.0, 0.0, 0.0),
    DHRow("c", -0.39225, 0.0, 0.0, 0.0),
    DHRow("d", 0.0, np.pi / 2, 0.10915, 0.0),
    DHRow("e", 0.0, -np.pi / 2, 0.09465, 0.0),
    DHRow("f", 0.0, 0.0, 0.0823, 0.0),
]
ODD = [
    DHRow("stand", 0.1, 0.3, 0.4, 0.5, "fixed"),
    DHRow("turn", 0.2, -0.7, 0.05, 1.1, lower=-3.0, upper=3.0, mass=2.0, com=(0.1, 0.02, -0.03)),
    DHRow("slide", -0.1, 0.9, 0.3, -0.4, "prismatic", -0.5, 0.5, mass=1.5, com=(0.0, 0.05, 0.2)),
    DHRow("roll", 0.05, 0.2, 0.1, 0.2),
    DHRow("tool", 0.0, 0.1, 0.15, 0.3, "fixed"),
]


def product(rows: list[DHRow], convention: Convention, q: np.ndarray) -> list[np.ndarray]:
    """The frame of each row, by the matrices of the textbooks."""
    T, frames, readings = np.eye(4), [], iter(q)
    for row in rows:
        reading = 0.0 if row.kind == "fixed" else next(readings)
        theta = row.theta + (reading if row.kind == "revolute" else 0.0)
        d = row.d + (reading if row.kind == "prismatic" else 0.0)
        screw_x = pose(rot_x(np.array(row.alpha)), np.array([row.a, 0, 0]))
        screw_z = pose(rot_z(np.array(theta)), np.array([0, 0, d]))
        T = T @ (screw_z @ screw_x if convention == "standard" else screw_x @ screw_z)
        frames.append(T)
    return frames


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("rows", [UR5, ODD], ids=["ur5", "odd"])
def test_the_flange_is_where_the_product_of_the_matrices_says(rows: list[DHRow], convention: Convention) -> None:
    robot = Robot.from_urdf(dh_urdf(rows, convention), flange="flange")
    assert robot.joints == tuple(row.name for row in rows if row.kind != "fixed")
    q = np.random.default_rng(1).uniform(-0.5, 0.5, (20, len(robot.joints)))
    expected = [product(rows, convention, row)[-1] for row in q]
    np.testing.assert_allclose(robot.forward(q[None])[0], expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_its_weight_hangs_where_the_rows_frames_say(convention: Convention) -> None:
    robot = Robot.from_urdf(dh_urdf(ODD, convention), flange="flange")

    def energy(q: np.ndarray) -> float:
        frames = product(ODD, convention, q)
        return sum(9.81 * row.mass * (T @ [*row.com, 1.0])[2] for row, T in zip(ODD, frames, strict=True))

    q, step = np.array([0.3, 0.1, -0.4]), 1e-6
    slopes = [(energy(q + step * e) - energy(q - step * e)) / (2 * step) for e in np.eye(3)]
    np.testing.assert_allclose(robot.gravity_torques(q[None])[0], slopes, rtol=0, atol=1e-7)


def test_limits_are_those_of_the_table() -> None:
    robot = Robot.from_urdf(dh_urdf(UR5, "standard"), flange="flange")
    assert robot.lower.tolist() == [-6.0] + [-np.inf] * 5
    assert robot.upper.tolist() == [6.0] + [np.inf] * 5


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([], "no joint that moves"),
        ([DHRow("tool", 0, 0, 0.1, 0, "fixed")], "no joint that moves"),
        ([DHRow("a", 0, 0, 0.1, 0), DHRow("a", 0, 0, 0.1, 0)], "two joints are named 'a'"),
        ([DHRow("a", 0, 0, 0.1, 0, "prismatic")], "'a' slides without limits"),
        ([DHRow("a", 0, 0, 0.1, 0, lower=1.0, upper=-1.0)], "lower limit 1 above its upper -1"),
        ([DHRow("a", 0, 0, 0.1, 0), DHRow("t", 0, 0, 0.1, 0, "fixed", mass=1.0)], "'t' is fixed and has a mass"),
    ],
)
def test_a_table_that_is_no_arm_is_refused_with_the_reason(rows: list[DHRow], said: str) -> None:
    with pytest.raises(RobotError, match=said):
        dh_urdf(rows, "standard")
