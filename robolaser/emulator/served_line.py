"""The near end of an arm's line: a pseudo terminal that a client opens as it would a serial port."""

import os
import tty
from typing import final

LARGEST_READ = 4096
MOST_PENDING = 65536
"""Bytes kept for a client that does not read; what comes after is lost, as on a line without flow control."""


@final
class ServedLine:
    """Bytes in, bytes out, never waiting.

    Attributes:
        address: What pyserial opens.
    """

    def __init__(self) -> None:
        near, self._far = os.openpty()
        self._near: int | None = near
        tty.setraw(self._far)
        os.set_blocking(near, False)
        self.address = os.ttyname(self._far)

    def waits_on(self) -> list[int]:
        """Descriptors that become readable when there is something to take."""
        return [] if self._near is None else [self._near]

    def take(self) -> bytes:
        """What came since."""
        if self._near is None:
            return b""
        try:
            return os.read(self._near, LARGEST_READ)
        except BlockingIOError:
            return b""

    def give(self, data: bytes) -> int:
        """Send as much as fits now; how much that was. When the plug is pulled all of it is gone."""
        if self._near is None:
            return len(data)
        try:
            return os.write(self._near, data)
        except BlockingIOError:
            return 0

    def hang_up(self) -> None:
        """Pull the plug."""
        if self._near is not None:
            os.close(self._near)
            os.close(self._far)
            self._near = None
