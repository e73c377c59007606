"""Simulated cells by keywords alone, for tests that vary any of them."""

from dataclasses import fields
from typing import Any

from robolaser.robot.kinematics import Robot
from robolaser.simulation import CellOptions, Simulated, simulate

OPTIONS = {field.name for field in fields(CellOptions)}


def simulate_as_asked(robot: Robot, **asked: Any) -> Simulated:
    """Call `simulate` with its options among the other keywords."""
    options = CellOptions(**{name: asked.pop(name) for name in OPTIONS & set(asked)})
    return simulate(robot, options=options, **asked)
