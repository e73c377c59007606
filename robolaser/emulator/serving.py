"""An emulated cell as a process: one line of JSON says where arm and camera are, then it serves until it is ended."""

import json
import os
import selectors
import signal
import stat

from robolaser.emulator.emulated_cell import EmulatedCell


def serve(cell: EmulatedCell) -> None:
    """Say where arm and camera are, and serve until killed, or until the pipe at standard input closes."""
    ended: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda which, frame: ended.append(which))
    print(json.dumps({"arm": cell.arm, "camera": cell.camera}), flush=True)
    try:
        while not ended and not _hung_up():
            cell.turn()
    finally:
        cell.close()


def _hung_up() -> bool:
    """Whether standard input is a pipe whose other end is closed."""
    try:
        if not stat.S_ISFIFO(os.fstat(0).st_mode):
            return False
        with selectors.DefaultSelector() as ready:
            ready.register(0, selectors.EVENT_READ)
            return bool(ready.select(0)) and not os.read(0, 1024)
    except OSError:
        return False
