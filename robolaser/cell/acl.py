"""The ACL controllers of SCORBOT arms, over RS-232."""

import re
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.cell.acl_protocol import SLOW_PERCENT, AclProtocol
from robolaser.cell.failures import line_lost, unclear
from robolaser.cell.serial_line import LineArm, SerialLine
from robolaser.data.cell_config import ArmLine, Axes
from robolaser.errors import ArmError, DataError
from robolaser.robot.kinematics import Robot

AXES = 5
PER_QUARTER = 33  # PAR 33 to 37: counts of axes 1 to 5 for 90 degrees; the sign is the encoder's
AT_REFERENCE = 52  # PAR 52 to 56: counts of axes 1 to 5 at the reference posture
MOST_COUNTS = 10_000_000
PLACES = ("RLP", "RLQ")
"""The controller's position names, overwritten in turn: one is stored while the arm moves to the other.

Names have five letters at most."""
SEARCH = "HOME"
HOMING_S = 300.0  # homing takes one to three minutes
HOMING_QUIET_S = 1.5
NUMBER = r"(-?\d{1,9})"  # longer ones come from a disturbed line
PAIRS = re.compile(rf"([1-8])\s*:\s*{NUMBER}(?=\s)")
WHOLE = re.compile(r"1\s*:[^>]*>")
PITCH = re.compile(rf"P\s*:\s*{NUMBER}(?=\s)")
PITCH_OFF = float(np.deg2rad(2.0))  # tolerance of equal pitches, up to sign and turns by pi
PITCH_CHANGED = float(np.deg2rad(6.0))  # from here on, agreement with the counts of an ER V plus is no coincidence
SPOILT = 4  # readings in a row: a disturbed line rarely corrupts as many
FOUND = re.compile(r"HOMING\s+COMPLETE", re.IGNORECASE)
FAILED = re.compile(r"HOM\w*\s+FAIL\w*\s+AXIS\s*(\d)", re.IGNORECASE)
HOMED = re.compile(f"{FOUND.pattern}|{FAILED.pattern}", re.IGNORECASE)


@final
class AclArm(LineArm):
    """A SCORBOT: encoder counts become joint angles by the controller's own parameters and the type of the arm.

    angles = reference_rad + direction M (counts - PAR(51 + axis)), M as in `radians_per_count`. Once the port is open,
    motors are on; nothing moves.
    """

    outputs: ClassVar[int | None] = 16
    synchronous_read: ClassVar[bool] = True
    absolute_encoders: ClassVar[bool] = False
    most: ClassVar[int] = AXES

    def __init__(self, line: SerialLine, arm: ArmLine, robot: Robot) -> None:
        super().__init__(line, arm, robot)
        joints = self._joints
        assert arm.axes is not None  # a cell without it is not read
        if arm.axes == "er5plus" and len(joints) < AXES:
            raise DataError(
                f"cell.toml, [arm] axes 'er5plus' couples {AXES} joints, but dataset.toml, [robot] joints lists"
                f" {len(joints)}. List all of them, base first.",
                file="dataset.toml",
                column="joints",
            )
        self._axes = arm.axes
        self._as_er5plus: list[float] = []
        self._talk = AclProtocol(line, joints)
        self._talk.begin()
        self._per_quarter = np.array([self._parameter(PER_QUARTER + i) for i in range(len(joints))])
        self._at_reference = np.array([self._parameter(AT_REFERENCE + i) for i in range(len(joints))])
        for i in np.flatnonzero(self._per_quarter == 0):
            raise ArmError(
                f"The controller on {line.port} reports PAR {PER_QUARTER + i} = 0, expected the counts for 90 degrees,"
                " not 0. Check its parameters and that cell.toml names the right arm."
            )
        self._per_count = radians_per_count(arm.axes, self._per_quarter)
        self._counts_per_rad = np.linalg.inv(self._per_count)
        self.step = np.linalg.norm(self._per_count, axis=1)
        self.read()
        self._talk.command("CON")
        self._talk.command(f"SPEED {SLOW_PERCENT}")
        for name in PLACES:  # may exist already; without them, HERE is refused
            self._talk.ask(f"DEFP {name}", lambda answer: True if ">" in answer else None)
        self._store_here()
        self._place = PLACES[0]
        self._prepared: Ints | None = None

    def read(self) -> Array:
        """Read the joint angles, (j,); an ArmError where the controller reports the pitch of another type of arm."""
        for _ in range(SPOILT):
            counts, pitch = self._talk.ask("LISTPV POSITION", self._counts_and_pitch)
            if not self._is_another_arm(counts, pitch):
                turned = self._per_count @ (counts - self._at_reference)
                return np.asarray(self._reference + self._direction * turned)
        raise ArmError(
            f"The controller on {self._line.port} reports a hand pitch of {np.rad2deg(pitch):.1f}°, which"
            f" contradicts its encoders if axes = '{self._axes}'. Check [arm] axes in cell.toml: this is another"
            " arm, and its joint angles would be wrong."
        )

    def poll_faults(self) -> None:
        """Raise the fault that a joint reports."""
        self._talk.listen()

    def start_move(self, q: Array, seconds: float) -> None:
        """Start a motion to angles, (j,)."""
        self.prepare(q)
        self._prepared = None
        self._talk.command(f"MOVE {self._place} {max(1, round(100 * seconds))}")

    def prepare(self, q: Array) -> None:
        """Store the goal of the next motion, in the position that is not the current goal."""
        exact = self._at_reference + self._counts_per_rad @ (self._direction * (q - self._reference))
        counts: Ints = np.rint(exact).astype(np.int64)
        if self._prepared is not None and (counts == self._prepared).all():
            return
        self._place = PLACES[1 - PLACES.index(self._place)]
        for _ in range(2):  # a disturbed line may have corrupted it
            for axis, count in enumerate(counts.tolist(), start=1):
                self._talk.command(f"SETPV {self._place} {axis} {count}")
            stored = self._talk.ask(f"LISTPV {self._place}", lambda answer: _listed(answer, len(self._joints)))
            if (stored == counts).all():
                self._prepared = counts
                return
        raise unclear(self._line.port, f"LISTPV {self._place}", str(stored.tolist()), 2)

    def stop(self) -> None:
        """Stop at the current position."""
        self._talk.abort()

    def home(self) -> None:
        """Search the home position."""
        self._talk.start(SEARCH)
        heard, polled, listens = "", False, False
        began = self._line.clock.now()
        while self._line.clock.now() - began < HOMING_S:
            text, ended = self._line.until(HOMED, HOMING_QUIET_S)
            heard += text
            failure = FAILED.search(heard)
            if failure:
                raise self._home_not_found(f"the switch of axis {failure[1]} was not found")
            self._talk.inspect(text, SEARCH)
            if ended:
                self._talk.settle()
                self._store_here()
                self._prepared = None
                return
            listens |= polled and bool(text)
            if listens and not text:
                raise line_lost(self._line.port, "it fell silent during homing")
            self._line.send("\r")  # a controller that listens while homing answers
            polled = True
        raise self._home_not_found(f"homing took more than {HOMING_S:.0f} s")

    def switch(self, output: int, *, on: bool) -> None:
        """Switch an output."""
        self._talk.command(f"SET OUT[{output}]={int(on)}")

    def _store_here(self) -> None:
        """Store the current counts in both positions, also of axes that are not this robot's."""
        for name in PLACES:
            self._talk.command(f"HERE {name}")

    def _home_not_found(self, reason: str) -> ArmError:
        return ArmError(
            f"The arm on {self._line.port} did not find its home: {reason}."
            " Move it clear of its stops by hand and try again."
        )

    def _counts_and_pitch(self, answer: str) -> tuple[Ints, float] | None:
        """Counts, (j,), and the hand's pitch in the world [rad], NaN if missing, in a listing."""
        counts, pitch = _listed(answer, len(self._joints)), PITCH.search(answer)
        return None if counts is None else (counts, np.deg2rad(int(pitch[1]) / 10) if pitch else np.nan)

    def _is_another_arm(self, counts: Ints, reported: float) -> bool:
        """Whether the reported pitch [rad] contradicts this type of arm at counts, (j,).

        An ER V plus's pitch follows from its counts and the controller's parameters. An arm that is stated to be an
        ER VII is not one if its changing pitch repeatedly follows from them.
        """
        if len(counts) < AXES or np.isnan(reported):
            return self._axes == "er5plus"
        pitch = float((_differential() @ (counts - self._at_reference))[3] * np.pi / 2 / self._per_quarter[3])
        others = np.array([reported, -reported, np.pi - reported, np.pi + reported])
        off = float(np.abs(np.angle(np.exp(1j * (pitch - others)))).min())
        if self._axes == "er5plus":
            return off > PITCH_OFF
        self._as_er5plus = [*self._as_er5plus, pitch] if off <= PITCH_OFF else []
        return float(np.ptp(self._as_er5plus or [0.0])) > PITCH_CHANGED

    def _parameter(self, number: int) -> int:
        """A parameter, read twice in a row with the same result: there is no check sum."""
        pattern = re.compile(rf"PAR\s*{number}\s*=\s*{NUMBER}\s")

        def value(answer: str) -> int | None:
            found = pattern.search(answer)
            return int(found[1]) if found else None

        values = [self._talk.ask(f"SHOW PAR {number}", value) for _ in range(2)]
        while values[-1] != values[-2]:
            if len(values) > 5:
                raise unclear(self._line.port, f"SHOW PAR {number}", str(values), len(values))
            values.append(self._talk.ask(f"SHOW PAR {number}", value))
        return values[-1]


def radians_per_count(axes: Axes, per_quarter: Array) -> Array:
    """Matrix from counts since the reference posture to joint angles since then, (j, j) [rad], by PAR 33 to 37, (j,).

    The ER VII counts each joint by itself. The ER V plus is decoupled: all its motors are in the base, so the elbow's
    encoder counts the forearm's angle in the world, and the hand's pitch in the world and its roll are half the
    difference and half the sum of encoders 4 and 5 (ACL reference guide for Controller-A, p. 7-10).
    """
    scaled = np.diag(np.pi / 2 / per_quarter)
    if axes == "er7":
        return scaled
    in_joints = np.eye(AXES) - np.diag([0.0, 1.0, 1.0, 0.0], -1)
    return in_joints @ scaled @ _differential()


def _differential() -> Array:
    """Matrix from counts of axes 1 to 5 to those of base, shoulder, elbow, pitch and roll, (5, 5)."""
    mixed = np.eye(AXES)
    mixed[3:, 3:] = [[0.5, -0.5], [0.5, 0.5]]
    return mixed


def _listed(answer: str, axes: int) -> Ints | None:
    """The counts of so many axes in a listing, (axes,); None if it is incomplete."""
    whole = WHOLE.search(answer)
    pairs = PAIRS.findall(whole[0])[:axes] if whole else []
    if [int(axis) for axis, _ in pairs] != list(range(1, axes + 1)):
        return None
    counts = np.array([int(count) for _, count in pairs])
    return counts if (np.abs(counts) < MOST_COUNTS).all() else None
