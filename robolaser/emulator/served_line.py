"""The near end of an arm's line: a pseudo terminal or a socket that a client opens as it would a serial port."""

import os
import socket
import termios
import tty
from abc import ABC, abstractmethod
from contextlib import suppress
from typing import final

import numpy as np

LARGEST_READ = 4096
MOST_PENDING = 65536
"""Bytes kept for a client that does not read; what comes after is lost, as on a line without flow control."""


class ServedLine(ABC):
    """Bytes in, bytes out, never waiting."""

    address: str
    """What pyserial opens."""

    @abstractmethod
    def waits_on(self) -> list[int]:
        """Descriptors that become readable when there is something to take."""

    @abstractmethod
    def take(self) -> bytes:
        """What came since."""

    @abstractmethod
    def give(self, data: bytes) -> int:
        """Send as much as fits now; how much that was. Without a client all of it is gone."""

    @abstractmethod
    def pull(self) -> None:
        """Pull the plug."""


@final
class PtyLine(ServedLine):
    """A pseudo terminal. Whoever opens it at another speed sends and receives garbage, as on a wire."""

    def __init__(self, baud: int, rng: np.random.Generator) -> None:
        self._near, self._far = os.openpty()
        tty.setraw(self._far)
        os.set_blocking(self._near, False)
        self.address = os.ttyname(self._far)
        self._speed = getattr(termios, f"B{baud}", None)
        self._rng = rng
        self._pulled = False
        speeds = termios.tcgetattr(self._far)
        if self._speed is not None:
            speeds[4] = speeds[5] = self._speed
            termios.tcsetattr(self._far, termios.TCSANOW, speeds)

    def waits_on(self) -> list[int]:
        """The near end; with a socket, server and client."""
        return [] if self._pulled else [self._near]

    def take(self) -> bytes:
        """What came since."""
        if self._pulled:
            return b""
        with suppress(BlockingIOError):
            return self._as_heard(os.read(self._near, LARGEST_READ))
        return b""

    def give(self, data: bytes) -> int:
        """Send what fits now."""
        if self._pulled:
            return len(data)
        with suppress(BlockingIOError):
            return os.write(self._near, self._as_heard(data))
        return 0

    def pull(self) -> None:
        """Close all ends."""
        if not self._pulled:
            self._pulled = True
            os.close(self._near)
            os.close(self._far)

    def _as_heard(self, data: bytes) -> bytes:
        """The bytes themselves, or what they look like at another speed."""
        if self._speed is None or termios.tcgetattr(self._far)[5] == self._speed:
            return data
        return self._rng.integers(0x80, 0x100, len(data), dtype=np.uint8).tobytes()


@final
class TcpLine(ServedLine):
    """A server for pyserial's socket:// that keeps one client at a time."""

    def __init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self._server.settimeout(0.0)
        self._client: socket.socket | None = None
        self.address = f"socket://127.0.0.1:{self._server.getsockname()[1]}"

    def waits_on(self) -> list[int]:
        """The near end; with a socket, server and client."""
        return [one.fileno() for one in (self._server, self._client) if one is not None and one.fileno() >= 0]

    def take(self) -> bytes:
        """What came since."""
        with suppress(OSError):
            client, _ = self._server.accept()
            client.settimeout(0.0)
            self._hang_up()
            self._client = client
        if self._client is None:
            return b""
        try:
            data = self._client.recv(LARGEST_READ)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._hang_up()
        return data

    def give(self, data: bytes) -> int:
        """Send what fits now."""
        if self._client is None:
            return len(data)
        try:
            return self._client.send(data)
        except BlockingIOError:
            return 0
        except OSError:
            self._hang_up()
            return len(data)

    def pull(self) -> None:
        """Close all ends."""
        self._hang_up()
        self._server.close()

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
