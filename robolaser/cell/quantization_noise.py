"""What a recording's dataset.toml states of its readings: a noise that comes of cutting them off at steps."""

import re
import tomllib
from collections.abc import Iterator
from copy import deepcopy

import numpy as np

from robolaser.arrays import Array
from robolaser.robot.kinematics import Robot

SECTION, KEY = "noise", "joint_rad"
HEADER = re.compile(r"^[ \t]*\[[ \t]*[\"']?noise[\"']?[ \t]*\].*$", re.MULTILINE)
DOTTED = re.compile(r"^[ \t]*[\"']?noise[\"']?[ \t]*\..*$", re.MULTILINE)


def quantization_rad(step: Array, robot: Robot) -> float:
    """Standard deviation of a reading that is cut off at steps, root mean square over the joints that turn [rad].

    Args:
        step: The smallest difference that the arm can tell, (j,) [rad or m].
        robot: Whose joints they are.
    """
    turning = step[~robot.prismatic]
    return float(np.sqrt(np.mean(turning**2) / 12.0)) if turning.size else 0.0


def with_noise(text: str, noise_rad: float) -> str | None:
    """dataset.toml with a standard deviation of readings [rad], unless it states one or there is none.

    Returns:
        None: It is written so that there is no place for it.
    """
    said = tomllib.loads(text)
    if noise_rad == 0 or KEY in said.get(SECTION, {}):
        return text
    wanted = deepcopy(said)
    wanted.setdefault(SECTION, {})[KEY] = float(f"{noise_rad:.2g}")
    return next((new for new in _written(text, said, f"{KEY} = {noise_rad:.2g}") if _says(new, wanted)), None)


def _written(text: str, said: dict[str, object], pair: str) -> Iterator[str]:
    """The text with one more key, in each place where it could stand."""
    line = f"{pair}   # the steps of the arm's readings over the root of 12"
    if SECTION not in said:
        yield f"{text.rstrip()}\n\n[{SECTION}]\n{line}\n"
    for header in HEADER.finditer(text):
        yield f"{text[: header.end()]}\n{line}{text[header.end() :]}"
    for dotted in DOTTED.finditer(text):
        yield f"{text[: dotted.start()]}{SECTION}.{line}\n{text[dotted.start() :]}"


def _says(text: str, wanted: dict[str, object]) -> bool:
    try:
        return tomllib.loads(text) == wanted
    except tomllib.TOMLDecodeError:
        return False
