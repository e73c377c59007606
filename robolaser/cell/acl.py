"""The ACL controllers of SCORBOT arms, over RS-232."""

import re
from collections.abc import Sequence
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.cell.acl_protocol import SLOW_PERCENT, AclProtocol
from robolaser.cell.arm import Arm
from robolaser.cell.clock import Clock
from robolaser.cell.failures import joints_differ, line_lost, unclear
from robolaser.cell.serial_line import SerialLine, connect
from robolaser.data.cell_config import ArmLine, Cell
from robolaser.errors import ArmError

AXES = 5
PER_QUARTER = 33
"""PAR 33 to 37: counts of axes 1 to 5 for 90 degrees; the sign is the encoder's."""
AT_REFERENCE = 52
"""PAR 52 to 56: counts of axes 1 to 5 at the reference posture."""
MOST_COUNTS = 10_000_000
PLACE = "RLP"
"""The controller's position that is overwritten for each motion; names have five letters at most."""
SEARCH = "HOME"
HOMING_S = 300.0
"""Homing takes one to three minutes."""
HOMING_QUIET_S = 1.5
PAIRS = re.compile(r"([1-8])\s*:\s*(-?\d+)(?=\s)")
WHOLE = re.compile(r"1\s*:[^>]*>")
PARAMETER = re.compile(r"(-?\d+)\s*>")
FOUND = re.compile(r"HOMING\s+COMPLETE", re.IGNORECASE)
FAILED = re.compile(r"HOM\w*\s+FAIL\w*\s+AXIS\s*(\d)", re.IGNORECASE)
HOMED = re.compile(f"{FOUND.pattern}|{FAILED.pattern}", re.IGNORECASE)


@final
class AclArm(Arm):
    """A SCORBOT: encoder counts become joint angles by the controller's own parameters.

    angle = reference_rad + direction (count - PAR(51 + axis)) (pi / 2) / PAR(32 + axis).
    """

    outputs: ClassVar[int | None] = 16
    synchronous_read: ClassVar[bool] = True
    absolute_encoders: ClassVar[bool] = False

    def __init__(self, line: SerialLine, arm: ArmLine, joints: Sequence[str]) -> None:
        if not 0 < len(joints) <= AXES:
            raise joints_differ("acl", len(joints), AXES)
        self._line = line
        self._joints = tuple(joints)
        self._talk = AclProtocol(line, self._joints)
        self._reference = np.array(arm.reference_rad or [0.0] * len(joints))
        self._direction = np.array(arm.direction or [1.0] * len(joints))
        self._talk.begin()
        self._per_quarter = np.array([self._parameter(PER_QUARTER + i) for i in range(len(joints))])
        self._at_reference = np.array([self._parameter(AT_REFERENCE + i) for i in range(len(joints))])
        for i in np.flatnonzero(self._per_quarter == 0):
            raise ArmError(
                f"The controller on {line.port} says PAR {PER_QUARTER + i} = 0, expected the counts for 90 degrees, not"
                " 0. Check its parameters and that cell.toml names the right arm."
            )
        self.step = np.abs(np.pi / 2 / self._per_quarter)
        self._talk.command("CON")
        self._talk.command(f"SPEED {SLOW_PERCENT}")
        self._talk.ask(f"DEFP {PLACE}", lambda said: True if "O.K." in said or "DEFINED" in said.upper() else None)
        self._talk.command(f"HERE {PLACE}")

    @classmethod
    def open(cls, cell: Cell, clock: Clock) -> Self:
        """Open the port, and read from the controller how it counts. Motors come on; nothing moves.

        Raises:
            ArmError: It cannot be opened, or the controller is not this robot's.
            DataError: The robot has more joints than the controller.
        """
        return connect(lambda line: cls(line, cell.arm, cell.robot.joints), cell.arm, clock)

    def read(self) -> Array:
        """Where it is now, (j,)."""
        return self._angles(self._counts("POSITION"))

    def poll_faults(self) -> None:
        """Whether a joint is in trouble."""
        self._talk.listen()

    def start_move(self, q: Array, seconds: float) -> None:
        """Start a motion to angles, (j,)."""
        counts = self._nearest(q)
        for _ in range(2):  # a disturbed line may have spoilt what was stored
            for axis, count in enumerate(counts.tolist(), start=1):
                self._talk.command(f"SETPV {PLACE} {axis} {count}")
            stored = self._counts(PLACE)
            if (stored == counts).all():
                break
        else:
            raise unclear(self._line.port, f"LISTPV {PLACE}", str(stored.tolist()), 2)
        self._talk.command(f"MOVE {PLACE} {max(1, round(100 * seconds))}")

    def stop(self) -> None:
        """Stop where it is."""
        self._talk.abort()

    def home(self) -> None:
        """Search its home."""
        self._talk.start(SEARCH)
        heard, asked, listens, silent = "", False, False, 0
        began = self._line.clock.now()
        while self._line.clock.now() - began < HOMING_S:
            text, ended = self._line.until(HOMED, HOMING_QUIET_S)
            heard += text
            failure = FAILED.search(heard)
            if failure:
                raise self._home_not_found(f"the switch of axis {failure[1]} was not found")
            self._talk.inspect(text, SEARCH)
            self._talk.check_restart()
            if ended:
                self._talk.settle()
                self._talk.command(f"HERE {PLACE}")
                return
            listens |= asked and bool(text)
            silent = 0 if text else silent + 1
            if listens and silent > 0:
                raise line_lost(self._line.port, "it fell silent during homing")
            self._line.send("\r")  # a controller that listens while homing answers
            asked = True
        raise self._home_not_found(f"homing took more than {HOMING_S:.0f} s")

    def laser_on(self, output: int) -> None:
        """Switch an output on."""
        self._talk.command(f"SET OUT[{output}]=1")

    def laser_off(self, output: int) -> None:
        """Switch an output off."""
        self._talk.command(f"SET OUT[{output}]=0")

    def close(self) -> None:
        """Close the port."""
        self._line.close()

    def _home_not_found(self, reason: str) -> ArmError:
        return ArmError(
            f"The arm on {self._line.port} did not find its home: {reason}."
            " Move it clear of its stops by hand and try again."
        )

    def _counts(self, place: str) -> Ints:
        """Encoder counts of the arm as it is, or of a position that is stored."""

        def all_axes(answer: str) -> Ints | None:
            whole = WHOLE.search(answer)
            pairs = PAIRS.findall(whole[0])[: len(self._joints)] if whole else []
            if [int(axis) for axis, _ in pairs] != list(range(1, len(self._joints) + 1)):
                return None
            counts = np.array([int(count) for _, count in pairs])
            return counts if (np.abs(counts) < MOST_COUNTS).all() else None

        return self._talk.ask(f"LISTPV {place}", all_axes)

    def _parameter(self, number: int) -> int:
        """A parameter, as two answers in a row say: there is no check sum."""

        def last_number(answer: str) -> int | None:
            found = PARAMETER.search(answer)
            return int(found[1]) if found else None

        said = [self._talk.ask(f"SHOW PAR {number}", last_number) for _ in range(2)]
        while said[-1] != said[-2]:
            if len(said) > 5:
                raise unclear(self._line.port, f"SHOW PAR {number}", str(said), len(said))
            said.append(self._talk.ask(f"SHOW PAR {number}", last_number))
        return said[-1]

    def _angles(self, counts: Ints) -> Array:
        angles: Array = self._reference + self._direction * (counts - self._at_reference) * (
            np.pi / 2 / self._per_quarter
        )
        return angles

    def _nearest(self, q: Array) -> Ints:
        counts = self._at_reference + self._direction * (q - self._reference) * self._per_quarter / (np.pi / 2)
        nearest: Ints = np.rint(counts).astype(np.int64)
        return nearest
