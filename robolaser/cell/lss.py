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
AT_ONCE = 8  # how often a halt is said without waiting, for a line that swallows bytes
SOON_S = 0.2  # longest wait for a servo to say where it is going, while it may be going elsewhere
SLOWEST = 10  # least cap on a servo's speed, for one that has nowhere to go [tenths of a degree/s]
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
        """Where it is now, (j,)."""
        return self._angles(self._all("QD"))

    def poll_faults(self) -> None:
        """Whether a joint is in trouble."""
        for servo, joint in self._servos:
            status = self._ask(servo, joint, "Q")
            if status in TROUBLE:
                raise alarm(self._line.port, joint, f"*{servo}Q{status}: {TROUBLE[status]}", ADVICE)

    def start_move(self, q: Array, seconds: float) -> None:
        """Start a motion to angles, (j,), all servos or none.

        The time that a motion is to take cannot be read back. So each servo is first given the speed that its way
        needs as its highest, and says that it heard; and all are halted, and told again, where one misheard its goal.
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
        """Stop where it is."""
        self._line.send(f"\r#{EVERYBODY}H\r" * AT_ONCE)

    def _halted(self) -> Ints:
        """Halt, and say where all stand, (j,) [tenths of a degree]."""
        before = now = self._all("QD")
        for _ in range(HALTS):
            self.stop()
            before, now = self._all("QD"), self._all("QD")
            if (before == now).all():
                return now
        raise unclear(self._line.port, f"#{EVERYBODY}H", f"{before.tolist()}, {now.tolist()}", HALTS)

    def _cap(self, fastest: Ints) -> None:
        """Set each servo's highest speed, (j,) [tenths of a degree/s], until its power is off."""
        for (servo, joint), speed in zip(self._servos, fastest.tolist(), strict=True):
            for _ in range(TRIES):
                self._line.send(f"#{servo}SD{speed}\r")
                heard = self._ask(servo, joint, "QSD")
                if heard == speed:
                    break
            else:
                raise self._unheard(f"#{servo}SD{speed}", heard)

    def _unheard(self, command: str, heard: int) -> AnswerUnclear:
        """What to raise where nobody moves, for one servo would not take a command.

        Raises:
            ArmAlarm: It is in trouble, and takes none.
        """
        self.stop()
        self.poll_faults()
        return unclear(self._line.port, command, str(heard), TRIES)

    def _all(self, what: str, *, tries: int = TRIES, quiet_s: float = QUIET_S) -> Ints:
        """What each servo answers, (j,)."""
        said = [self._ask(servo, joint, what, tries=tries, quiet_s=quiet_s) for servo, joint in self._servos]
        return np.array(said, dtype=np.int64)

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
            silence = f"servo {servo} ({joint}) gave no answer for {tries * quiet_s:.1f} s"
            raise line_lost(self._line.port, silence)
        raise unclear(self._line.port, f"#{servo}{what}", heard, tries)
