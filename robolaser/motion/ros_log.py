"""Bags of ROS as logs of moving arms: each reading of the joints, and the command that was last sent before it."""

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.importers.importer import ImportOptions
from robolaser.data.importers.ros_bag import JOINT_TOPIC
from robolaser.data.importers.ros_messages import ARRAY, CONTROLLER, JOINTS, STAMPS, Bag, JointTrack
from robolaser.motion.recorders import RecordedRun
from robolaser.robot.kinematics import Robot

COMMAND_TOPIC: Final = "commands"
PAUSE_S = 1.0
"""Without readings for so long, another series begins."""


def bag_runs(source: Path, robot: Robot, options: ImportOptions) -> list[RecordedRun]:
    """The runs of a bag.

    Readings are joint states, or what a controller's state says that it read; commands are those of a controller's
    state, of joint states of another topic, or of an array in the robot's order. An array has no time of its own: then
    all times are those at which the messages were recorded.

    Args:
        source: The bag.
        robot: The arm.
        options: `joints` and `commands` of `further` name the topics where there are several.

    Raises:
        DataError: The bag cannot be read, or has no readings of all joints.
        UsageError: Several topics may be meant.
        DependencyMissing: The package rosbags is not installed.
    """
    stated = options.further
    with Bag.opened([source], stated.get(STAMPS)) as bag:
        told = stated.get(COMMAND_TOPIC)
        read = stated.get(JOINT_TOPIC)
        of_controllers = bag.topics(CONTROLLER)
        told = told or next(iter(bag.topics(ARRAY) or of_controllers), None)
        if told is not None and read is None:
            states = [topic for topic in bag.topics(JOINTS) if topic != told]
            read = states[0] if len(states) == 1 else None
        read = bag.topic(JOINT_TOPIC, read or (None if bag.topics(JOINTS) else told), JOINTS, CONTROLLER)
        timed = replace(bag, received=bag.received or told in bag.topics(ARRAY))
        track = timed.joints(read, robot.joints)
        command = None if told is None else timed.joints(told, robot.joints, commanded=True)
    columns = {"time_s": track.time_s}
    for quantity, values in (("q", track.q), ("qd", track.qd), ("tau", track.effort)):
        if values is not None:
            columns |= {f"{quantity}_{joint}": values[:, j] for j, joint in enumerate(robot.joints)}
    if command is not None:
        columns |= {f"command_{joint}": each for joint, each in zip(robot.joints, _held(command, track).T, strict=True)}
    begins = np.flatnonzero(np.diff(track.time_s) > PAUSE_S) + 1
    parts = np.split(np.arange(len(track.time_s)), begins)
    return [
        RecordedRun(
            source.stem if len(parts) == 1 else f"{source.stem}_{number + 1}",
            source.name,
            {name: values[rows] for name, values in columns.items()},
            angle_unit="rad",
        )
        for number, rows in enumerate(parts)
    ]


def _held(command: JointTrack, track: JointTrack) -> Array:
    """The command that holds at each reading, (n, j); NaN before the first."""
    last = np.searchsorted(command.time_s, track.time_s, side="right") - 1
    return np.where((last >= 0)[:, None], command.q[np.maximum(last, 0)], np.nan)
