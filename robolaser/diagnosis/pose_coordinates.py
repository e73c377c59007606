"""Coordinates of poses that an error may depend on, with their names in reports."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.path_velocities import known_velocities
from robolaser.model.effects.run import Run

TIME: Final = "time"  # name of the coordinate along the run
LEAST_TORQUE_NM: Final = 1e-6  # least range of a joint's gravity torque
RECORDED: Final = {"temperature_c": ("temperature", "°C"), "payload_kg": ("payload", "kg")}
"""Words and units of recorded conditions."""


@final
@dataclass(frozen=True, eq=False)
class Coordinate:
    """A quantity with one or more values at each pose."""

    name: str  # its name in reports
    values: Array  # its values at each pose, (n, k)
    unit: str = ""  # "rad", "m", "rad/s", "m/s", "Nm", "°C", "kg", "sign" of a direction, "share of the run", or ""


def of_run(run: Run) -> Iterator[Coordinate]:
    """Coordinates that any error may depend on: time and recorded conditions that vary."""
    poses = run.poses
    if poses.time_s is not None and np.ptp(run.progress) > 0:
        yield Coordinate(TIME, run.progress[:, None], "share of the run")
    for name, values in poses.coordinates.items():
        if np.ptp(values) > 0:
            word, unit = RECORDED.get(name, (name, ""))
            yield Coordinate(word, values[:, None], unit)


def angle_of(run: Run, joint: str) -> Coordinate:
    """The angle or position of a joint."""
    column = run.robot.joints.index(joint)
    return Coordinate(f"angle of {joint}", run.q[:, [column]], "m" if run.robot.prismatic[column] else "rad")


def torque_of(run: Run, joint: str) -> Iterator[Coordinate]:
    """The gravity torque at a joint, if it varies."""
    torque = run.loads.gravity_torques[:, [run.robot.joints.index(joint)]] if run.robot.has_masses else np.zeros((1, 1))
    if np.ptp(torque) > LEAST_TORQUE_NM:
        yield Coordinate(f"gravity torque at {joint}", torque, "Nm")


def motion_of(run: Run, joint: str) -> Iterator[Coordinate]:
    """A joint's direction of approach and its velocity, if known and varying."""
    column = run.robot.joints.index(joint)
    if run.dataset.path_known and run.poses.time_s is not None:
        approach = run.approach[:, [column]].astype(np.float64)
        if np.ptp(approach) > 0:
            yield Coordinate(f"direction of approach of {joint}", approach, "sign")
    qd = known_velocities(run.dataset)
    if qd is not None and np.ptp(qd[:, column]) > 0:
        unit = "m/s" if run.robot.prismatic[column] else "rad/s"
        yield Coordinate(f"velocity of {joint}", qd[:, [column]], unit)


def hanging(run: Run) -> Iterator[Coordinate]:
    """The direction of gravity in the flange frame."""
    robot = run.dataset.robot
    if robot is None or np.any(robot.gravity):
        yield Coordinate("direction of gravity in the flange", run.gravity_in_flange)


def overturning(run: Run) -> Iterator[Coordinate]:
    """The moment of the arm's weight about the base's origin."""
    robot = run.dataset.robot
    if robot is not None and robot.has_masses and np.ptp(run.loads.overturning_moment) > 0:
        yield Coordinate("overturning moment", run.loads.overturning_moment, "Nm")
