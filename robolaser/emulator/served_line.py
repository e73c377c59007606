"""The near end of an arm's line: a pseudo terminal or a socket that a client opens as it would a serial port."""

import os
import socket
import termios
import tty
from contextlib import suppress
from typing import final

import numpy as np

LARGEST_READ = 4096
MOST_PENDING = 65536
"""Bytes kept for a client that does not read; what comes after is lost, as on a line without flow control."""


class ServedLine:
    """Bytes in, bytes out, never waiting.

    Attributes:
        address: What pyserial opens.
        near: Descriptor of the end that is served; None: nobody is there.
    """

    address: str
    near: int | None = None

    def waits_on(self) -> list[int]:
        """Descriptors that become readable when there is something to take."""
        return [] if self.near is None else [self.near]

    def take(self) -> bytes:
        """What came since."""
        if self.near is None:
            return b""
        try:
            data = os.read(self.near, LARGEST_READ)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self.hang_up()
        return data

    def give(self, data: bytes) -> int:
        """Send as much as fits now; how much that was. Without a client all of it is gone."""
        if self.near is None:
            return len(data)
        try:
            return os.write(self.near, data)
        except BlockingIOError:
            return 0
        except OSError:
            self.hang_up()
            return len(data)

    def hang_up(self) -> None:
        """Let go of the client."""
        if self.near is not None:
            os.close(self.near)
            self.near = None

    def pull(self) -> None:
        """Pull the plug."""
        self.hang_up()


@final
class PtyLine(ServedLine):
    """A pseudo terminal. Whoever opens it at another speed sends and receives garbage, as on a wire."""

    def __init__(self, baud: int, rng: np.random.Generator) -> None:
        self.near, self._far = os.openpty()
        tty.setraw(self._far)
        os.set_blocking(self.near, False)
        self.address = os.ttyname(self._far)
        self._speed = getattr(termios, f"B{baud}", None)
        self._rng = rng
        speeds = termios.tcgetattr(self._far)
        if self._speed is not None:
            speeds[4] = speeds[5] = self._speed
            termios.tcsetattr(self._far, termios.TCSANOW, speeds)

    def take(self) -> bytes:
        """What came since."""
        return self._as_heard(super().take())

    def give(self, data: bytes) -> int:
        """Send what fits now."""
        return super().give(self._as_heard(data))

    def hang_up(self) -> None:
        """Close both ends."""
        if self.near is not None:
            super().hang_up()
            os.close(self._far)

    def _as_heard(self, data: bytes) -> bytes:
        """The bytes themselves, or what they look like at another speed."""
        if self.near is None or self._speed is None or termios.tcgetattr(self._far)[5] == self._speed:
            return data
        return self._rng.integers(0x80, 0x100, len(data), dtype=np.uint8).tobytes()


@final
class TcpLine(ServedLine):
    """A server for pyserial's socket:// that keeps one client at a time."""

    def __init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self._server.settimeout(0.0)
        self.address = f"socket://127.0.0.1:{self._server.getsockname()[1]}"

    def waits_on(self) -> list[int]:
        """Server and client."""
        return [*super().waits_on(), *([self._server.fileno()] if self._server.fileno() >= 0 else [])]

    def take(self) -> bytes:
        """What came since, from the client that came last."""
        with suppress(OSError):
            client, _ = self._server.accept()
            client.settimeout(0.0)
            self.hang_up()
            self.near = client.detach()
        return super().take()

    def pull(self) -> None:
        """Let go of the client, and take no other."""
        super().pull()
        self._server.close()
