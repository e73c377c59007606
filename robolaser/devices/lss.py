"""Arms of Lynxmotion's smart servos, several on one line, each with an address."""

import re
from collections.abc import Sequence
from typing import Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell import ArmLine
from robolaser.devices.arm import Arm
from robolaser.devices.clock import Clock
from robolaser.devices.line import Line
from robolaser.errors import AnswerUnclear, ArmAlarm, ArmDiffers, ArmRefused, LineLost

EVERYBODY = 254
STEP = np.deg2rad(0.1)
"""Servos count in tenths of a degree."""
QUIET_S = 0.6
TRIES = 3
TROUBLE = {7: "outside its limits", 8: "stuck", 9: "blocked", 10: "in safe mode"}
ADVICE = "Free the arm, let it cool down, and switch its power off and on."


@final
class Lss(Arm):
    """Servos that know their angles from the moment they are switched on: there is no home to search."""

    def __init__(self, line: Line, arm: ArmLine, joints: Sequence[str]) -> None:
        if not joints:
            raise ArmDiffers("lss", 0, EVERYBODY - 1)
        self._line = line
        self._ids = arm.ids or tuple(range(1, len(joints) + 1))
        self._servos = tuple(zip(self._ids, joints, strict=True))
        self._reference = np.array(arm.reference_rad or [0.0] * len(joints))
        self._direction = np.array(arm.direction or [1.0] * len(joints))
        self.step = np.full(len(joints), STEP)
        line.drop()
        line.send("\r")  # ends whatever was left half said
        self.read()

    @classmethod
    def open(cls, arm: ArmLine, joints: Sequence[str], clock: Clock) -> Self:
        """Open the port and see that every servo answers.

        Raises:
            PortUnusable: It cannot be opened.
        """
        line = Line.open(arm, clock)
        try:
            return cls(line, arm, joints)
        except BaseException:
            line.close()
            raise

    def read(self) -> Array:
        """Where it is now, (j,)."""
        tenths = np.empty(len(self._ids))
        for i, (servo, joint) in enumerate(self._servos):
            tenths[i] = self._ask(servo, joint, "QD")
        angles: Array = self._reference + self._direction * tenths * STEP
        return angles

    def watch(self) -> None:
        """Whether a joint is in trouble."""
        for servo, joint in self._servos:
            status = self._ask(servo, joint, "Q")
            if status in TROUBLE:
                raise ArmAlarm(self._line.port, joint, f"*{servo}Q{status}: {TROUBLE[status]}", ADVICE)

    def go(self, q: Array, seconds: float) -> None:
        """Set out to angles, (j,); a servo that misheard its goal is told again at once."""
        tenths = np.rint(self._direction * (q - self._reference) / STEP).astype(np.int64)
        wanted = dict(zip(self._ids, tenths.tolist(), strict=True))
        for _ in range(TRIES):
            for servo, goal in wanted.items():
                self._line.send(f"#{servo}D{goal}T{max(1, round(1000 * seconds))}\r")
            heard = {servo: self._ask(servo, joint, "QDT") for servo, joint in self._servos if servo in wanted}
            wanted = {servo: goal for servo, goal in wanted.items() if heard[servo] != goal}
            if not wanted:
                return
        self.watch()  # a servo in trouble takes no goal
        servo, goal = next(iter(wanted.items()))
        raise AnswerUnclear(self._line.port, f"#{servo}D{goal}", str(heard[servo]), TRIES)

    def stop(self) -> None:
        """Stop where it is."""
        self._line.send(f"\r#{EVERYBODY}H\r")

    def home(self) -> None:
        """Nothing: they know where they are."""

    def light(self, output: int) -> None:
        """Switch an output on."""
        self._no_outputs(output)

    def dark(self, output: int) -> None:
        """Switch an output off."""
        self._no_outputs(output)

    def close(self) -> None:
        """Let go of it."""
        self._line.close()

    def _ask(self, servo: int, joint: str, what: str) -> int:
        heard = ""
        pattern = re.compile(rf"\*{servo}{what}(-?\d+)\r")
        for _ in range(TRIES):
            self._line.drop()
            self._line.send(f"#{servo}{what}\r")
            text, answer = self._line.until(pattern, QUIET_S)
            if answer:
                return int(answer[1])
            heard += text
        if not heard:
            silence = f"servo {servo} ({joint}) gave no answer for {TRIES * QUIET_S:.1f} s"
            raise LineLost(self._line.port, silence)
        raise AnswerUnclear(self._line.port, f"#{servo}{what}", heard, TRIES)

    def _no_outputs(self, output: int) -> None:
        raise ArmRefused(
            self._line.port, f"output {output}", "", "these servos switch nothing; take [laser] out of cell.toml"
        )
