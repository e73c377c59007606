"""Arms of Lynxmotion's smart servos, several on one line, each with an address."""

import re
from contextlib import suppress
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.cell.clock import PEAK
from robolaser.cell.failures import AnswerUnclear, alarm, line_lost, unclear
from robolaser.cell.serial_line import BusArm, SerialLine
from robolaser.data.cell_config import ArmLine
from robolaser.errors import LineLost
from robolaser.robot.kinematics import Robot

EVERYBODY = 254
QUIET_S = 0.6
TRIES = 3
STARTS = 5
HALTS = 5
AT_ONCE = 8  # repetitions of a halt without waiting, for a line that loses bytes
SOON_S = 0.2  # longest wait for a servo to confirm its goal while it may move to another
SLOWEST = 10  # least speed limit, also of a servo that need not move [tenths of a degree/s]
TROUBLE = {7: "outside its limits", 8: "stuck", 9: "blocked", 10: "in safe mode"}
ADVICE = "Free the arm, let it cool down, and switch its power off and on."


@final
class LssArm(BusArm):
    """Servos that count in tenths of a degree, and speed in tenths of a degree a second."""

    synchronous_read: ClassVar[bool] = False
    counted_rad: ClassVar[float] = float(np.deg2rad(0.1))
    most: ClassVar[int] = EVERYBODY - 1

    def __init__(self, line: SerialLine, arm: ArmLine, robot: Robot) -> None:
        super().__init__(line, arm, robot)
        self._servos = tuple(zip(self._ids, self._joints, strict=True))
        line.discard()
        line.send("\r")  # ends a command that was left incomplete
        self.read()

    def read(self) -> Array:
        """Read the joint angles, (j,)."""
        return self._angles(self._all("QD"))

    def poll_faults(self) -> None:
        """Raise the fault that a joint reports."""
        for servo, joint in self._servos:
            status = self._ask(servo, joint, "Q")
            if status in TROUBLE:
                raise alarm(self._line.port, joint, f"*{servo}Q{status}: {TROUBLE[status]}", ADVICE)

    def start_move(self, q: Array, seconds: float) -> None:
        """Start a motion to angles, (j,), all servos or none.

        The duration of a motion cannot be read back. So each servo first gets its motion's speed as its limit, and
        confirms it; where one misheard its goal, all are halted and commanded again.
        """
        goal = self._counts(q)
        heard = goal
        for _ in range(STARTS):
            way = np.abs(goal - self._halted())
            self._cap(np.maximum(np.ceil(PEAK * way / seconds), SLOWEST).astype(np.int64))
            for servo, tenths in zip(self._ids, goal.tolist(), strict=True):
                self._line.send(f"#{servo}D{tenths}T{max(1, round(1000 * seconds))}\r")
            with suppress(LineLost, AnswerUnclear):
                heard = self._all("QDT", tries=1, quiet_s=SOON_S)
                if (heard == goal).all():
                    return
            self.stop()
        i = int(np.argmax(heard != goal))
        raise self._unheard(f"#{self._ids[i]}D{goal[i]}", int(heard[i]))

    def stop(self) -> None:
        """Stop at the current position."""
        self._line.send(f"\r#{EVERYBODY}H\r" * AT_ONCE)

    def _halted(self) -> Ints:
        """Halt, and return all positions, (j,) [tenths of a degree]."""
        before = now = self._all("QD")
        for _ in range(HALTS):
            self.stop()
            before, now = self._all("QD"), self._all("QD")
            if (before == now).all():
                return now
        raise unclear(self._line.port, f"#{EVERYBODY}H", f"{before.tolist()}, {now.tolist()}", HALTS)

    def _cap(self, fastest: Ints) -> None:
        """Set each servo's speed limit, (j,) [tenths of a degree/s], until its power is off."""
        for (servo, joint), speed in zip(self._servos, fastest.tolist(), strict=True):
            for _ in range(TRIES):
                self._line.send(f"#{servo}SD{speed}\r")
                heard = self._ask(servo, joint, "QSD")
                if heard == speed:
                    break
            else:
                raise self._unheard(f"#{servo}SD{speed}", heard)

    def _unheard(self, command: str, heard: int) -> AnswerUnclear:
        """The error where no servo moves because one did not take a command, unless that servo reports a fault."""
        self.stop()
        self.poll_faults()
        return unclear(self._line.port, command, str(heard), TRIES)

    def _all(self, what: str, *, tries: int = TRIES, quiet_s: float = QUIET_S) -> Ints:
        """The answer of each servo, (j,)."""
        answers = [self._ask(servo, joint, what, tries=tries, quiet_s=quiet_s) for servo, joint in self._servos]
        return np.array(answers, dtype=np.int64)

    def _ask(self, servo: int, joint: str, what: str, *, tries: int = TRIES, quiet_s: float = QUIET_S) -> int:
        heard = ""
        pattern = re.compile(rf"\*{servo}{what}(-?\d{{1,9}})\r")
        for _ in range(tries):
            self._line.discard()
            self._line.send(f"#{servo}{what}\r")
            text, answer = self._line.until(pattern, quiet_s)
            if answer:
                return int(answer[1])
            heard += text
        if not heard:
            raise line_lost(self._line.port, f"servo {servo} ({joint}) gave no answer for {tries * quiet_s:.1f} s")
        raise unclear(self._line.port, f"#{servo}{what}", heard, tries)
