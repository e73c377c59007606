"""What a recording's dataset.toml states of its readings: a noise that comes of cutting them off at steps."""

import re
import tomllib

import numpy as np

from robolaser.arrays import Array
from robolaser.robot.kinematics import Robot

SECTION, KEY = "noise", "joint_rad"
HEADER = re.compile(r"^[ \t]*\[[ \t]*[\"']?noise[\"']?[ \t]*\].*$", re.MULTILINE)


def quantization_rad(step: Array, robot: Robot) -> float:
    """Standard deviation of a reading cut off at steps, (j,) [rad or m], RMS over the joints that turn [rad]."""
    turning = step[~robot.prismatic]
    return float(np.sqrt(np.mean(turning**2) / 12.0)) if turning.size else 0.0


def with_noise(text: str, noise_rad: float) -> str | None:
    """dataset.toml with a standard deviation of readings [rad], unless it states one or there is none.

    Returns:
        None: Its [noise] is no section with a line of its own.
    """
    said = tomllib.loads(text)
    if noise_rad == 0 or KEY in said.get(SECTION, {}):
        return text
    line = f"{KEY} = {noise_rad:.2g}   # the steps of the arm's readings over the root of 12"
    if SECTION not in said:
        return f"{text.rstrip()}\n\n[{SECTION}]\n{line}\n"
    new = HEADER.sub(rf"\g<0>\n{line}", text, count=1)
    return new if KEY in tomllib.loads(new)[SECTION] else None
