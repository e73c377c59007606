"""Motions: one is over when readings show the arm at rest at its goal, not when the controller reports it."""

from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell.arm import Arm
from robolaser.cell.clock import Clock, seconds_for, way_in
from robolaser.cell.failures import AnswerUnclear, ArmAlarm, ArmRestarted, NotSettled, at_worst, not_settled
from robolaser.data.cell_config import UNATTENDED_S
from robolaser.errors import ArmError, PlanError, RobolaserError
from robolaser.robot.kinematics import Robot

POLL_S = 0.05
ALIKE_S = 0.1  # time between two equal readings of rest: a disturbed line does not repeat an error
STEPS = 2.5  # of the encoder: tolerance at the goal
NEAR = np.deg2rad(0.1)  # least tolerance at the goal, whatever the encoders: servos relax a little [rad or m]
STRAY = np.deg2rad(3.0)  # largest path deviation: joints overshoot or accelerate late [rad or m]
PATIENCE = 2.0  # a motion may take this multiple of its planned duration,
PATIENCE_S = 4.0  # and so much longer
STILL_S = 3.0  # a joint away from its goal that rests for a motion's duration and so much longer will not arrive
STOPPED_ALIKE = 3  # equal readings after a stop: a bad line may lose a sign in two; the next run starts there
STOPPING_S = 1.0  # an arm that still moves so long after the stop command did not receive it
STOPS = 5
TINY = 1e-12


@final
class Mover:
    """Moves one arm from configuration to configuration and monitors it.

    Raises (every method): NotSettled where it does not come to rest; ArmError where it rests elsewhere, or leaves the
    straight path; and what the arm raises.
    """

    def __init__(self, arm: Arm, robot: Robot, speed: float, clock: Clock, unattended_s: float = UNATTENDED_S) -> None:
        self._arm = arm
        self._robot = robot
        self._speed = speed
        self._clock = clock
        self._unattended_s = np.inf if arm.stops_alone else unattended_s
        self.near = np.maximum(STEPS * arm.step, NEAR)
        unsure = float((self.near + arm.step).max())
        self._piece = way_in(self._unattended_s, speed) - unsure
        """Way of a joint from stop to stop: from anywhere within the tolerance of one, it reaches the next in time."""
        if self._piece < unsure:
            slowest = np.ceil(1e3 * 2 * unsure * speed / way_in(self._unattended_s, speed)) / 1e3
            raise PlanError(
                f"cell.toml, [limits] speed_rad_s: {speed:g} is too slow for this arm's encoders: in pieces of"
                f" {self._unattended_s:g} s it would not be seen to move. State {slowest:g} or more, or a longer"
                " unattended_s in [arm]."
            )

    def resting(self, when: str, patience_s: float = STILL_S, *, alike: int = 2) -> Array:
        """The arm's position at rest, by so many equal readings in a row, (j,)."""
        began = self._clock.now()
        before, same = self._arm.read(), 1
        while True:
            self._clock.wait(ALIKE_S)
            now = self._arm.read()
            moved = np.abs(now - before)
            same = same + 1 if (moved <= STEPS * self._arm.step).all() else 1
            if same == alike:
                return now
            if same == 1 and self._clock.now() - began > patience_s:
                raise not_settled(when, *at_worst(self._robot, moved, moved))
            before = now

    def move_and_wait(self, goal: Array, place: str, start: Array) -> Array:
        """Move straight in joint space from rest to a goal, (j,) each, and wait until the arm is at rest there.

        The stops on the way are so near to each other that the arm comes to rest soon if communication ends. Each
        piece is timed from the measured position, so that no joint exceeds the speed. Messages call the goal `place`.

        Returns:
            The measured position, at rest, (j,).
        """
        legs = max(1, int(np.ceil(np.abs(goal - start).max(initial=0.0) / self._piece)))
        stops = np.linspace(start, goal, legs + 1)
        at = start
        for leg in range(legs):
            then = stops[leg + 2] if leg + 2 <= legs else None
            way = np.abs(stops[leg + 1] - at) + self._arm.step  # readings and goals are rounded
            seconds = min(seconds_for(way, self._speed), self._unattended_s)
            at = self._leg(stops[leg], stops[leg + 1], then, seconds, place)
        return at

    def _leg(self, start: Array, goal: Array, then: Array | None, seconds: float, place: str) -> Array:
        """Move to a stop, (j,); wait for rest there unless a motion to a next one, (j,), follows."""
        self._arm.start_move(goal, seconds)
        if then is not None:
            self._arm.prepare(then)
        began = alike = self._clock.now()
        before, last, moved, astray = start, start, np.full(len(goal), began), 0
        while True:
            if not astray:
                self._clock.wait(POLL_S)
            self._arm.poll_faults()
            q = self._arm.read()
            now = self._clock.now()
            moving = np.abs(q - before) > STEPS * self._arm.step
            there = np.abs(q - goal) <= self.near
            if moving.any():
                alike = now
            elif now - alike >= ALIKE_S and there.all():
                return q
            if then is not None and there.all():
                return q
            before, moved = np.where(moving, q, before), np.where(moving, now, moved)
            off = self._off(q, last, start, goal)
            astray, last = astray + 1 if (off > STRAY).any() else 0, q
            if astray > 1:  # one reading alone may be the line's fault
                joint, at, away, begin, end = at_worst(self._robot, off, q, off, start, goal)
                raise ArmError(
                    f"On the way to {place}, {joint} is at {at}, {away} off the straight path from"
                    f" {begin} to {end} that was checked: it sticks, lags behind the others, or goes"
                    " elsewhere. Look for what blocks it, and check [arm] direction and reference_rad in cell.toml, and"
                    " the serial line."
                )
            stuck = ~there & (now - moved > STILL_S + seconds)  # a joint with a short way is slow to be seen moving
            if stuck.any():
                raise self._not_arrived(place, q, np.where(stuck, goal, q), "stands still")
            if now - began > PATIENCE * seconds + PATIENCE_S:
                raise self._not_arrived(place, q, goal, f"is still on its way after {now - began:.0f} s,")

    def halt(self, *, restarted: bool = False) -> Array:
        """Stop the arm and return its position at rest, (j,); ignore reports of a restart that is known."""
        trouble: RobolaserError | None = None
        no_news = (NotSettled, ArmAlarm, AnswerUnclear, *((ArmRestarted,) if restarted else ()))
        for _ in range(STOPS):
            try:
                self._arm.stop()
                return self.resting("After the stop command", STOPPING_S, alike=STOPPED_ALIKE)
            except no_news as error:
                trouble = error
        assert trouble is not None
        raise trouble

    def _off(self, q: Array, last: Array, start: Array, goal: Array) -> Array:
        """Deviation of each joint from the straight way, at the nearest point to all joints, (j,).

        Joints that are read one after the other seem to deviate by up to their motion between readings.
        """
        way = goal - start
        share = np.clip((q - start) @ way / max(float(way @ way), TINY), 0.0, 1.0)
        apart = 0.0 if self._arm.synchronous_read else np.abs(q - last)
        return np.asarray(np.abs(q - start - share * way) - apart)

    def _not_arrived(self, place: str, q: Array, goal: Array, reason: str) -> ArmError:
        joint, at, wanted = at_worst(self._robot, np.abs(q - goal) / self.near, q, goal)
        return ArmError(
            f"On the way to {place}, {joint} {reason} at {at}, not {wanted}."
            " Look for what blocks it, and check that its motors are on."
        )
