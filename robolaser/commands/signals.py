"""The ways in which a program is ended from outside."""

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Never


@contextmanager
def ended_as_by_hand() -> Iterator[None]:
    """Whoever ends the program (a closed terminal, a batch system) ends it as Ctrl-C does: in good order."""

    def stop(number: int, frame: FrameType | None) -> Never:
        raise KeyboardInterrupt

    ends = [signal.SIGTERM] if sys.platform == "win32" else [signal.SIGTERM, signal.SIGHUP]
    before = {end: signal.signal(end, stop) for end in ends}
    try:
        yield
    finally:
        for end, action in before.items():
            signal.signal(end, action)
