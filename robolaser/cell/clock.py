"""The time that machines take."""

import time
from typing import final


@final
class Clock:
    """The time on the wall."""

    def now(self) -> float:
        """Seconds since some moment; never runs backwards."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Let time go by."""
        time.sleep(seconds)
