"""Arms on a serial line: transmission, reception and timeouts of text in Latin-1."""

import re
from typing import Any, ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.cell.arm import Arm
from robolaser.cell.clock import Clock
from robolaser.cell.failures import joints_differ, line_lost
from robolaser.data.cell_config import ArmLine, Cell
from robolaser.errors import ArmError
from robolaser.robot.kinematics import Robot

SCHEMES = ("socket", "rfc2217", "loop")  # allowed URLs; loop:// receives what it sends
LETTERS = "latin-1"
TICK_S = 0.02  # longest duration of one poll for bytes
WRITE_S = 1.0  # timeout of sending
MOST = 16_384  # characters without a valid answer; the longest answer has some hundred
LONGEST_S = 6.0  # of sending without a valid answer; the longest takes a quarter of a second at 9600 baud


@final
class SerialLine:
    """Text from and to a device, over what pyserial opens.

    Raises (every method): LineLost where the port is gone, ArmError where the device sends without end.
    """

    def __init__(self, wire: Any, port: str, clock: Clock) -> None:
        self.port = port
        self.clock = clock
        self._transport = wire
        self._heard = ""

    @classmethod
    def open(cls, arm: ArmLine, clock: Clock) -> Self:
        """Open a port, 8 bits, no parity, one stop bit: a device, `socket://HOST:PORT` or `rfc2217://HOST:PORT`."""
        scheme, separator, _ = arm.port.partition("://")
        if separator and scheme.lower() not in SCHEMES:  # spy:// truncates files, alt:// loads code by name
            raise ArmError(
                f"Port {arm.port}: {scheme}:// is not allowed. Use a device such as /dev/ttyUSB0, or"
                f" socket://HOST:PORT or rfc2217://HOST:PORT."
            )
        import serial  # noqa: PLC0415 - importing devices opens nothing, and loads nothing either

        try:
            wire: Any = serial.serial_for_url(
                arm.port,
                baudrate=arm.baud,
                xonxoff=arm.flow == "xonxoff",
                timeout=TICK_S,
                write_timeout=WRITE_S,
                exclusive=True if "://" not in arm.port else None,
            )
        except (OSError, ValueError) as error:
            raise _cannot_open(arm.port, _reason(error)) from None
        return cls(wire, arm.port, clock)

    def send(self, data: str) -> None:
        """Send text."""
        try:
            self._transport.write(data.encode(LETTERS))
        except (OSError, TypeError) as error:  # a port closed under pyserial's feet is a TypeError
            raise line_lost(self.port, _reason(error)) from None

    def discard(self) -> str:
        """Discard all text received so far, and return it."""
        dropped, self._heard = self._heard, ""
        while new := self._look(wait=0):
            dropped += new
            if len(dropped) > MOST:
                raise self._flooded(len(dropped))
        return dropped

    def until(self, pattern: "re.Pattern[str]", quiet_s: float) -> tuple[str, "re.Match[str] | None"]:
        """Receive until the text matches, the line is silent for a while, or other text comes for too long.

        Returns:
            The text up to the end of the match, and the match; all text and None, where nothing matched.
        """
        began = last = self.clock.now()
        while True:
            found = pattern.search(self._heard)
            if found:
                text, self._heard = self._heard[: found.end()], self._heard[found.end() :]
                return text, found
            if len(self._heard) > MOST:
                raise self._flooded(len(self._heard))
            looked = self.clock.now()  # after a delay of this program, received text is read first
            new = self._look(wait=1)
            self._heard += new
            if new:
                last = self.clock.now()
            if looked > min(last + quiet_s, began + LONGEST_S):
                text, self._heard = self._heard, ""
                return text, None

    def close(self) -> None:
        """Close the port."""
        self._transport.close()

    def _flooded(self, received: int) -> ArmError:
        return ArmError(
            f"The arm on {self.port} sends without end: {received} bytes and no answer among them."
            " Stop the program in the controller and check [arm] baud in cell.toml."
        )

    def _look(self, *, wait: int) -> str:
        try:
            data = self._transport.read(wait) if wait else b""
            waiting = self._transport.in_waiting
            if waiting:
                data += self._transport.read(waiting)
        except (OSError, TypeError) as error:
            raise line_lost(self.port, _reason(error)) from None
        return data.decode(LETTERS)


def _reason(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__).rstrip(".")


def _cannot_open(port: str, reason: str) -> ArmError:
    from serial.tools.list_ports import comports  # noqa: PLC0415

    present = sorted(one.device for one in comports() if one.hwid != "n/a")
    found = f"This machine has: {', '.join(present)}." if present else "No serial port is to be seen on this machine."
    return ArmError(
        f"Cannot open port {port}: {reason}. {found} Check the cable, that no other program holds the port and that"
        " you may use it (on Linux: group dialout), and name it in cell.toml, [arm] port, or with --port."
    )


class LineArm(Arm):
    """angle = reference_rad + direction (the controller's counts as an angle)."""

    most: ClassVar[int]  # joints that can share the line

    def __init__(self, line: SerialLine, arm: ArmLine, robot: Robot) -> None:
        self._line, self._joints = line, robot.joints
        count = len(self._joints)
        if not 0 < count <= self.most:
            raise joints_differ(arm.kind, count, self.most)
        self._reference = np.array(arm.reference_rad or [0.0] * count)
        self._direction = np.array(arm.direction or [1.0] * count)

    @classmethod
    def open(cls, cell: Cell, clock: Clock) -> Self:
        """Open the port and start its protocol; after a failure the port is closed."""
        line = SerialLine.open(cell.arm, clock)
        try:
            return cls(line, cell.arm, cell.robot)
        except BaseException:
            line.close()
            raise

    def close(self) -> None:
        """Close the port."""
        self._line.close()


class BusArm(LineArm):
    """Servos with absolute encoders, and no output."""

    outputs: ClassVar[int | None] = 0
    absolute_encoders: ClassVar[bool] = True
    counted_rad: ClassVar[float]  # angle of one count of a servo [rad]

    def __init__(self, line: SerialLine, arm: ArmLine, robot: Robot) -> None:
        super().__init__(line, arm, robot)
        self._ids = arm.ids or tuple(range(1, len(self._joints) + 1))
        self.step = np.full(len(self._joints), self.counted_rad)

    def home(self) -> None:
        """Nothing: their encoders are absolute."""

    def _angles(self, counts: Ints) -> Array:
        return np.asarray(self._reference + self._direction * counts * self.counted_rad)

    def _counts(self, q: Array) -> Ints:
        return np.asarray(np.rint(self._direction * (q - self._reference) / self.counted_rad).astype(np.int64))
