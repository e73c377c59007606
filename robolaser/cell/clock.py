"""The time that machines take."""

import time
from abc import ABC, abstractmethod
from typing import final


class Clock(ABC):
    """Tells how much time went by, and waits."""

    @abstractmethod
    def now(self) -> float:
        """Seconds since some moment; never runs backwards."""

    @abstractmethod
    def wait(self, seconds: float) -> None:
        """Let time go by."""


@final
class WallClock(Clock):
    """The time on the wall."""

    def now(self) -> float:
        """Seconds since some moment."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Sleep."""
        time.sleep(seconds)
