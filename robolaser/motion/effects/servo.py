"""Servos that follow their commands with delay, lag, droop, dead zone or limits."""

from functools import partial

import numpy as np

from robolaser.arrays import Array
from robolaser.motion.effect import OF_ANGLE, TIMING, MotionEffect, Number, Trace, if_sent
from robolaser.motion.servo import IDEAL

ONE_CLOCK_S, ONE_CLOCK_SHARE = 1e-3, 0.2  # largest apparent difference between delays of one clock. A judgement
P_GAIN = "the servo's P gain (`P_Coefficient` in LeRobot)"
HOBBY = "Feetech STS3215 and Dynamixel manuals: P control with a dead band of some encoder steps"
SURVEY = "Armstrong-Hélouvry, Dupont, Canudas de Wit 1994, Automatica 30: a survey of friction and its compensation"
LOOPS = "Siciliano et al. 2009, Robotics, ch. 8: independent joint control; a lag of one over the position loop's gain"

HOLDS_NM = 1e-3  # least spread of a joint's gravity torque for droop to be tested. A judgement
DIFFERS = 0.2
"""Share of a motion's torque spread that must not be gravity for the two to be distinguishable. A judgement."""
EXCEEDS_RAD, EXCEEDS_ERRORS = 0.05, 3.0
"""Margin by which commands exceed all readings at a limit, and the same in errors of the joint: what a dead
zone and droop leave is no limit. A judgement."""


def is_one_clock(delays: Array) -> bool:
    """Whether the delays of several joints may come from one clock."""
    return bool(np.ptp(delays) <= max(ONE_CLOCK_S, ONE_CLOCK_SHARE * np.abs(delays).max()))


def _beyond(trace: Trace) -> tuple[bool, bool]:
    """Whether commands go beyond the lowest and the highest reading."""
    least = max(EXCEEDS_RAD, EXCEEDS_ERRORS * trace.error_within)
    low, high = np.nanmin(trace.q) - np.nanmin(trace.command), np.nanmax(trace.command) - np.nanmax(trace.q)
    return bool(low > least), bool(high > least)


def _range_begins(numbers: tuple[Number, ...], trace: Trace, size: float, spread: float) -> list[float]:
    """Start at the ends of the readings that commands exceed."""
    ends = zip(numbers, (np.nanmin(trace.q), np.nanmax(trace.q)), _beyond(trace), strict=True)
    return [float(end) / number.usual if there else IDEAL[number.servo] for number, end, there in ends]


def _droop_untested(trace: Trace) -> str:
    if np.nanstd(trace.holding) < HOLDS_NM:
        return "the URDF's masses put no gravity torque on this joint that changes"
    return if_sent(trace)


def _yield_untested(trace: Trace) -> str:
    if np.nanstd(trace.moving - trace.holding) < DIFFERS * max(float(np.nanstd(trace.moving)), HOLDS_NM):
        return "the torque of the motion is nearly that of gravity"
    return if_sent(trace)


def _speed_begins(numbers: tuple[Number, ...], trace: Trace, size: float, spread: float) -> list[float]:
    """Start at the speed of the fastest commands, or a part of it."""
    speed = np.abs(np.diff(trace.command, axis=0)) / trace.step_s[:-1]
    return [float(np.nanpercentile(speed, 99.0)) / (size * numbers[0].usual)]


def _width_begins(numbers: tuple[Number, ...], trace: Trace, size: float, spread: float) -> list[float]:
    """Start at a part of the remaining spread."""
    return [0.4 * size * spread / numbers[0].usual]


of_servo = partial(MotionEffect, rows="tracking", cause="servo")
"""Defaults of an effect of a servo."""
CLOCK = of_servo(
    name="clock_shift", clause="readings and commands are stamped by two clocks", cause="timing", site=TIMING,
    numbers=(Number("delay", "s", 0.005, -0.2, 0.2, servo="delay"),),
    remedy="Give commands and readings the stamps of one clock, each at its own instant.",
    reference="Furgale, Rehder, Siegwart 2013, IROS: temporal calibration; 1-30 ms are usual", rivals=("dead_time",),
    rarity=4.0,  # every servo has a delay, and few logs have wrong stamps
)  # fmt: skip
TRACKING = (
    CLOCK,
    of_servo(
        name="dead_time", clause="commands take effect late", cause="timing",
        numbers=(Number("delay", "s", 0.01, 0.0, 0.5, servo="delay", least=1e-3),),
        remedy="Add this delay to the simulated actuator, less one row of the log if it holds commands from row to row,"
        " or send commands that much earlier.",
        reference="Hwangbo et al. 2019, Science Robotics 4: actuators' delays of 5-30 ms; hobby buses up to 100 ms",
        rivals=("lag", "clock_shift"),
    ),
    of_servo(
        name="lag", clause="the joint follows its command with a lag",
        numbers=(Number("time", "s", 0.02, 0.0, 2.0, servo="time"),),
        remedy="Raise the servo's P gain, or give the simulated actuator the lag.", reference=LOOPS,
        rivals=("dead_time", "speed_limit"),
    ),
    of_servo(
        name="lag", form="second order", clause="the joint follows its command with a lag",
        numbers=(
            Number("time", "s", 0.02, 0.0, 2.0, servo="time"),
            Number("inertia", "s²", 4e-4, 0.0, 0.25, servo="second"),  # over the position loop's gain
        ),
        remedy="Raise the servo's gains, or give the simulated actuator the lag.", reference=LOOPS,
        rivals=("lag", "dead_time"),
    ),
    of_servo(
        name="offset", clause="the joint has a constant offset from its command",
        numbers=(Number("angle", "rad", 0.005, -0.7, 0.7, servo="angle", least=2e-3),),
        remedy="Correct the joint's zero: `homing_offset` in LeRobot's calibration, the zero of its controller.",
        reference=HOBBY, rivals=("droop", "scale"), imitated_by=(OF_ANGLE,), untested=lambda trace: "",
    ),
    of_servo(
        name="scale", clause="the joint moves by a wrong multiple of its command",
        numbers=(Number("factor", "", 0.01, -0.5, 0.5, servo="scale", least=0.002),),
        rarity=14.0,  # commands and readings have one unit in nearly every log
        remedy="Check the unit and range of commands: ticks a turn, per cent of range, degrees.",
        reference="LeRobot calibration files: ranges in ticks; 4095 for 4096 ticks is a scale of 0.024 %",
        rivals=("offset",), imitated_by=(OF_ANGLE,),
    ),
    of_servo(
        name="range_limit", clause="the joint stops at a limit that the command exceeds",
        numbers=(Number("lower", "rad", 0.05, servo="lower"), Number("upper", "rad", 0.05, servo="upper")),
        remedy="Give the simulated joint these limits, or widen the controller's.", reference=HOBBY,
        untested=lambda trace: "" if any(_beyond(trace)) else "no command exceeds the range that the joint reached",
        begins=_range_begins,
    ),
    of_servo(
        name="droop", clause="the joint sinks under gravity",
        numbers=(Number("compliance", "rad/Nm", 0.02, -3.0, 3.0, servo="compliance"),),
        remedy=f"Raise {P_GAIN}, add an I term, or give the simulated actuator this stiffness.", reference=LOOPS,
        rivals=("offset",), imitated_by=(OF_ANGLE,), untested=_droop_untested,
    ),
    of_servo(
        name="droop", form="under torque", clause="the joint deflects under its torque",
        numbers=(Number("torque_compliance", "rad/Nm", 0.02, -3.0, 3.0, servo="yields"),),
        remedy=f"Raise {P_GAIN}, feed the torque forward, or give the simulated actuator this stiffness.",
        reference=LOOPS, rivals=("offset", "lag"), imitated_by=(OF_ANGLE,), untested=_yield_untested,
    ),
    of_servo(
        name="dead_zone", clause="the servo ignores errors below a dead zone",
        numbers=(Number("half_width", "rad", 0.01, 0.0, 0.5, servo="dead"),),
        remedy=f"Raise {P_GAIN}, or reduce its dead band; gear friction looks the same.", reference=SURVEY,
        rivals=("play",), begins=_width_begins,
    ),
    of_servo(
        name="play", clause="the joint has play behind the servo's loop", cause="transmission",
        numbers=(Number("half_width", "rad", 0.01, 0.0, 0.5, servo="lost"),),
        remedy="Adjust or preload the gear, or approach each pose from one side.",
        reference="Nordin, Gutman 2002, Automatica 38: controlling mechanical systems with backlash",
        rivals=("dead_zone",),
        rarity=4.0,  # most loops close on the encoder that is read, which does not show play behind it
        begins=_width_begins,
    ),
    of_servo(
        name="speed_limit", clause="the joint cannot move as fast as commanded",
        numbers=(Number("speed", "rad/s", 0.2, 0.01, np.inf, servo="speed"),),
        remedy="Command no faster than this, or give the simulated actuator the limit.",
        reference="Data sheets of servos: no-load speed, 2-8 rad/s", rivals=("lag",), begins=_speed_begins,
    ),
)  # fmt: skip
