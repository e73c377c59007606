"""Going somewhere and being there: a motion is over when the arm rests at its goal, not when it was told to go."""

from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.devices.angles import shown
from robolaser.devices.arm import Arm
from robolaser.devices.clock import Clock
from robolaser.errors import ArmAlarm, NotArrived, Restless, Strayed
from robolaser.robot import Robot

POLL_S = 0.05
ALIKE_S = 0.1
"""Two readings so far apart in time that agree are a rest, and no disturbed line says the same wrong thing twice."""
STEPS = 2.5
"""Of the encoder: how near is there."""
NEAR = np.deg2rad(0.1)
"""How near to its goal an arm rests at least, however fine its encoders: servos let go a little [rad or m]."""
STRAY = np.deg2rad(3.0)
"""How far an arm may be off the straight way of one joint: they overshoot, and do not start all at once."""
PATIENCE = 2.0
PATIENCE_S = 4.0
"""A motion may take this many times as long as it was given, and so much longer."""
STILL_S = 3.0
"""Who has not moved for so long will not arrive."""
STOPPING_S = 1.0
"""An arm that still moves so long after it was told to stop did not hear it."""
STOPS = 5
PEAK = 1.875
"""Highest speed over mean speed of the smoothest motions usual (a polynomial of fifth degree)."""
LEAST_S = 0.5


def seconds_for(way: Array, speed: float) -> float:
    """Time for a motion so that no joint ever exceeds a speed [s].

    Args:
        way: Differences of joint values, (j,) [rad or m].
        speed: [rad/s or m/s].
    """
    return max(LEAST_S, PEAK * float(np.abs(way).max(initial=0.0)) / speed)


@final
class Mover:
    """Takes one arm from place to place, watching it."""

    def __init__(self, arm: Arm, robot: Robot, speed: float, clock: Clock) -> None:
        self._arm = arm
        self._robot = robot
        self._speed = speed
        self._clock = clock
        self.near = np.maximum(STEPS * arm.step, NEAR)

    def resting(self, when: str, patience_s: float = STILL_S) -> Array:
        """Where the arm stands, as two readings in a row say, (j,).

        Raises:
            Restless: It moves.
        """
        began = self._clock.now()
        before = self._arm.read()
        while True:
            self._clock.wait(ALIKE_S)
            now = self._arm.read()
            moved = np.abs(now - before)
            if (moved <= STEPS * self._arm.step).all():
                return now
            if self._clock.now() - began > patience_s:
                worst = int(np.argmax(moved))
                raise Restless(when, self._robot.joints[worst], shown(self._robot, worst, float(moved[worst])))
            before = now

    def travel(self, goal: Array, place: str, start: Array) -> Array:
        """Go straight, joint by joint, to a goal, and wait until the arm rests there.

        Args:
            goal: (j,).
            place: What messages call it.
            start: Where it rests now, (j,).

        Returns:
            Where it rests, as read, (j,).

        Raises:
            NotArrived: It rests elsewhere, or does not come to rest.
            Strayed: It is on another way than the straight one.
        """
        seconds = seconds_for(goal - start, self._speed)
        self._arm.go(goal, seconds)
        began = moved = alike = self._clock.now()
        before, astray = start, 0
        while True:
            self._clock.wait(POLL_S)
            self._arm.watch()
            q = self._arm.read()
            now = self._clock.now()
            if (np.abs(q - before) > STEPS * self._arm.step).any():
                before, alike = q, now
                moved = now
            elif now - alike >= ALIKE_S and (np.abs(q - goal) <= self.near).all():
                return q
            astray = astray + 1 if self._off(q, start, goal).any() else 0
            if astray > 1:  # one reading alone may be the line's fault
                joint = int(np.argmax(self._off(q, start, goal)))
                raise Strayed(place, self._robot.joints[joint], *self._shown(joint, q, start, goal))
            if now - moved > STILL_S:
                raise self._not_arrived(place, q, goal, "stands still")
            if now - began > PATIENCE * seconds + PATIENCE_S:
                raise self._not_arrived(place, q, goal, f"is still on its way after {now - began:.0f} s,")

    def halt(self) -> Array:
        """Stop the arm and see that it stands, (j,).

        Raises:
            Restless: It moves on whatever it is told.
            RobolaserError: The line does not let it be stopped.
        """
        trouble: Restless | ArmAlarm | None = None
        for _ in range(STOPS):
            self._arm.stop()
            try:
                return self.resting("After it was told to stop", STOPPING_S)
            except (Restless, ArmAlarm) as error:  # what it reports now is no news
                trouble = error
        assert trouble is not None
        raise trouble

    def _off(self, q: Array, start: Array, goal: Array) -> Array:
        """How much further than allowed each joint is from between start and goal, (j,); 0: it is not."""
        outside = np.maximum(np.minimum(start, goal) - q, q - np.maximum(start, goal))
        too_far: Array = np.maximum(outside - STRAY, 0.0)
        return too_far

    def _shown(self, joint: int, *postures: Array) -> tuple[str, ...]:
        return tuple(shown(self._robot, joint, float(q[joint])) for q in postures)

    def _not_arrived(self, place: str, q: Array, goal: Array, reason: str) -> NotArrived:
        joint = int(np.argmax(np.abs(q - goal) / self.near))
        stands, wanted = self._shown(joint, q, goal)
        return NotArrived(place, self._robot.joints[joint], stands, wanted, reason)
