"""A recording of an arm that somebody else moves: by hand, with its teach pendant, or by a program of its own."""

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from robolaser.arrays import Array
from robolaser.cell.arm import Arm
from robolaser.cell.camera import Camera
from robolaser.cell.clock import Clock
from robolaser.cell.recording_writer import RecordingWriter, Sample
from robolaser.errors import RobolaserError

AT_A_TIME_S = 2.0  # how much may be lost when the computer dies; to write interrupts the recording for a moment


def watch(
    arm: Arm,
    camera: Camera,
    writer: RecordingWriter,
    clock: Clock,
    count: int,
    laser_output: int | None,
    recorded: Callable[[str], None],
    settle_s: float = 0.0,
) -> None:
    """Take images one after the other, and read the joints before and after each. Nothing is moved.

    An image's time is when it came. The angles then, and their velocities, are on the line between both readings. How
    long before it came an image was exposed, nobody knows: the effect `latency` finds it.

    Args:
        arm: What is moved by others.
        camera: One that runs by itself.
        writer: Of a recording that has no plan.
        clock: Of the time stamps.
        count: How many images.
        laser_output: The controller's output that is on meanwhile; None: none is.
        recorded: Is called with the name of each sample once it is on the disk.
        settle_s: How long the laser takes to light up in the images [s].

    Raises:
        RobolaserError: Of arm, camera or disk; what was recorded up to then is whole.
    """
    began = clock.now()
    waiting: list[Sample] = []
    written_s = began
    try:
        if laser_output is not None:
            arm.switch(laser_output, on=True)
            camera.shot(settle_s)  # the first one may have been exposed before
        for name in sample_names(count):
            arm.poll_faults()
            before_s, before = _reading(arm, clock)
            image = camera.shot(0.0)
            came_s = clock.now()
            after_s, after = _reading(arm, clock)
            qd = (after - before) / (after_s - before_s)
            q = before + qd * (came_s - before_s)
            waiting.append(Sample(name, came_s - began, q, {"image": image}, qd))
            if clock.now() - written_s > AT_A_TIME_S:
                _write(writer, waiting, recorded)
                written_s = clock.now()
    finally:
        if laser_output is not None:
            with suppress(RobolaserError):
                arm.switch(laser_output, on=False)
        _write(writer, waiting, recorded)


def sample_names(count: int) -> list[str]:
    """w001, w002, ..."""
    digits = max(3, len(str(count)))
    return [f"w{i:0{digits}d}" for i in range(1, count + 1)]


def _reading(arm: Arm, clock: Clock) -> tuple[float, Array]:
    """Joint angles, (j,), and the middle of the time that it took to read them [s]."""
    asked_s = clock.now()
    q = arm.read()
    return (asked_s + clock.now()) / 2, np.asarray(q)


def _write(writer: RecordingWriter, waiting: list[Sample], recorded: Callable[[str], None]) -> None:
    if waiting:
        writer.add(waiting)
        for sample in waiting:
            recorded(sample.name)
        waiting.clear()
