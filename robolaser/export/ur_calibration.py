"""calibration.yaml: the corrected arm in the format of Universal Robots' ROS driver and description.

Their links have their own frames, each turning about its z (ur_description, `default_kinematics.yaml`); URDFs of other
origin have others. Each of their frames is on the line of a joint of the nominal arm, and moves with it.
"""

import re
from hashlib import sha256
from typing import Final

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.export.controller_table import joint_lines
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose, rot_x, rot_y, rot_z
from robolaser.robot.kinematics import Robot
from robolaser.robot.urdf.elements import origin_attributes

LINKS: Final = {  # the makers' names of the links, and of the joints that turn them
    "shoulder": "shoulder_pan_joint",
    "upper_arm": "shoulder_lift_joint",
    "forearm": "elbow_joint",
    "wrist_1": "wrist_1_joint",
    "wrist_2": "wrist_2_joint",
    "wrist_3": "wrist_3_joint",
}
KEYS: Final = ("x", "y", "z", "roll", "pitch", "yaw")
DIGITS: Final = 12  # after the point; never an exponent, which PyYAML reads as a word
NEAR: Final = 0.01  # largest distance from a joint's line to the makers': measured arms differ by less [m, 1]


def ur_calibration(calibration: Calibration) -> str | None:
    """The file; None where the arm is none of theirs, or no correction fits into it."""
    robot, corrected = calibration.model.dataset.robot, calibration.robot
    nominal = None if robot is None else _frames(robot)
    if robot is None or corrected is None or corrected is robot or nominal is None:
        return None
    zero = np.zeros(len(robot.joints))
    frames = np.concatenate(
        [nominal[:1], corrected.joint_frames(zero) @ inverse(robot.joint_frames(zero)) @ nominal[1:]]
    )
    lines = []
    for name, step in zip(LINKS, inverse(frames[:-1]) @ frames[1:], strict=True):
        numbers = " ".join(origin_attributes(step).values()).split()
        lines.append(f"  {name}:\n")
        lines += [
            f"    {key}: {round(float(value), DIGITS) + 0.0:.{DIGITS}f}\n"
            for key, value in zip(KEYS, numbers, strict=True)
        ]
    digest = sha256("".join(lines).encode()).hexdigest()[:20]
    return f"kinematics:\n{''.join(lines)}  hash: calib_{digest}\n"


def flange_by_ur_calibration(text: str, robot: Robot, q: Array) -> Array:
    """Flange poses by a calibration.yaml, in the nominal arm's base, (n, 6) [rad] -> (n, 4, 4).

    The nominal arm's flange is on the makers' last link; other arms are a ValueError.
    """
    nominal = _frames(robot)
    if nominal is None:
        raise ValueError("Only arms by Universal Robots have a calibration.yaml.")
    numbers = np.array([float(found[1]) for found in re.finditer(r"^    \w+: (\S+)$", text, re.MULTILINE)])
    T: Array = np.tile(nominal[0], (len(q), 1, 1))
    for (*xyz, roll, pitch, yaw), angle in zip(numbers.reshape(len(LINKS), len(KEYS)), q.T, strict=True):
        turned = rot_z(yaw) @ rot_y(pitch) @ rot_x(roll) @ rot_z(angle)
        T = T @ pose(turned, np.broadcast_to(xyz, (len(q), 3)))
    return np.asarray(T @ inverse(nominal[-1]) @ robot.forward(np.zeros(len(LINKS))))


def _frames(robot: Robot) -> Array | None:
    """The makers' frames of base and links at the arm's zero, (7, 4, 4) in the arm's base; None for other arms."""
    if robot.joints != tuple(LINKS.values()):
        return None
    at, z, flange = joint_lines(robot)
    back = at[1] - at[2]  # the arm is stretched out
    for line in (z[1], z[0]):
        back -= (back @ line) * line
    back /= np.linalg.norm(back)
    base = pose(np.column_stack([back, np.cross(z[0], back), z[0]]), at[0] - (at[0] @ z[0]) * z[0])
    (x, y, up) = ((at - base[:3, 3]) @ base[:3, :3]).T
    end = min(y[5], ((flange[:3, 3] - base[:3, 3]) @ base[:3, :3])[1] if robot.flange == "tool0" else y[5])
    half = np.array(np.pi / 2)
    steps = [
        pose(np.eye(3), np.array([0.0, 0.0, up[1]])),
        pose(rot_x(half), np.zeros(3)),
        pose(np.eye(3), np.array([x[2], 0.0, 0.0])),
        pose(np.eye(3), np.array([x[3] - x[2], 0.0, -y[4]])),
        pose(rot_x(half), np.array([0.0, up[5] - up[3], 0.0])),
        pose(rot_x(-half), np.array([0.0, y[4] - end, 0.0])),
    ]
    frames = [base]
    for step, point, line in zip(steps, at, z, strict=True):
        ideal = frames[-1] @ step
        off = ideal[:3, 3] - point
        off -= (off @ line) * line
        turn = np.cross(ideal[:3, 2], line)
        if max(np.linalg.norm(off), np.linalg.norm(ideal[:3, 2] - line)) > NEAR:
            return None
        frames.append(pose(exp_so3(turn) @ ideal[:3, :3], ideal[:3, 3] - off))
    return np.stack(frames)
