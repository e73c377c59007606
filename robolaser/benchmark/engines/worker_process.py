"""A worker process, seen from the program that started it: it makes one run after another and cannot outlive us."""

import os
import pickle
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any, final

from robolaser.benchmark.engines.engine import Job
from robolaser.benchmark.engines.worker import BEGUN, NEEDED, READY

GRACE_S = 5.0
"""A run whose time is up is stopped at its next evaluation; one that has not returned this much later is killed."""
STARTUP_S = 120.0
"""Time allowed for imports and for building the problem, on a busy machine."""
WARM_UP_S = 60.0
"""Extra time allowed for the uncounted first evaluations: they may compile loops that no process has compiled yet."""
_LONGEST_S = 1e6  # the longest wait that the system accepts

_ENVIRONMENT = {
    **{f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "NUMBA", "NUMEXPR")},
    "VECLIB_MAXIMUM_THREADS": "1",
    "PYTHONHASHSEED": "0",  # the order of sets is the same everywhere
}


class WorkerTimeout(Exception):
    """A worker did not answer in time."""

    def __init__(self, allowed_s: float) -> None:
        super().__init__(allowed_s)
        self.allowed_s = allowed_s


@final
class WorkerProcess:
    """A process that makes one run after another, and does not outlive this one.

    Attributes:
        began: When the clock of the present run began, `time.monotonic`; None before.
        heard: Whether it has sent anything about the present run.
        used: Whether it has made a run before the present one.
    """

    def __init__(self) -> None:
        ours, theirs = socket.socketpair()
        their_end, our_end = os.pipe()  # nothing is ever sent over it: the worker dies when our end is closed
        with theirs:
            fds = theirs.fileno(), their_end
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "robolaser.benchmark.engines.worker", *map(str, fds)],
                pass_fds=fds,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # a group that can be killed as a whole, and that Ctrl-C does not reach
                env=os.environ | _ENVIRONMENT | {"PYTHONPATH": os.pathsep.join(import_paths())},
            )
        self._connection, self._lifeline = Connection(ours.detach()), Connection(our_end, readable=False)
        os.close(their_end)
        self.began: float | None = None
        self.heard = self.used = False

    @property
    def pid(self) -> int:
        """The system's number of the process."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether it still runs."""
        return self._process.poll() is None

    def do(
        self, job: Job, digest: str, payload: Callable[[], bytes], paths: tuple[str, ...], *, warm_up: bool
    ) -> tuple[Any, bool]:
        """Have it do a job for a program with these import paths; also return whether it is fit for another.

        Raises:
            WorkerTimeout: It did not answer in time.
            EOFError, OSError: It died.
        """
        self.began, self.heard = None, False
        self._connection.send((digest, paths, warm_up, pickle.dumps(job)))
        allowed_s = STARTUP_S
        while self._connection.poll(min(allowed_s, _LONGEST_S)):
            message = self._connection.recv()
            self.heard = True
            if message == NEEDED:
                self._connection.send_bytes(payload())
            elif message == READY:
                allowed_s = job.time_limit_s + GRACE_S + WARM_UP_S
            elif message == BEGUN:
                self.began = time.monotonic()
                allowed_s = job.time_limit_s + GRACE_S
            else:
                made, fit = message
                self.used = True
                return made, fit
        raise WorkerTimeout(allowed_s)

    def autopsy(self) -> str:
        """Kill it after its connection broke, and return what it died of."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(0.2)
        code = self._process.poll()
        self.kill()
        if code is None:
            return "it closed the connection to its process; killed"
        if code >= 0:
            return f"it ended its process, with exit code {code}"
        with suppress(ValueError):
            cause = "killed from outside or out of memory" if -code == signal.SIGKILL else signal.Signals(-code).name
            return f"its process died (signal {-code}, {cause})"
        return f"its process died (signal {-code})"

    def kill(self) -> None:
        """Kill it and everything that it started, at once; from any thread, so its connections are left open."""
        with suppress(OSError):  # nobody is left of its group
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()


def import_paths() -> tuple[str, ...]:
    """Import paths of this process, and the current directory, last: users' solvers may lie there."""
    return tuple(dict.fromkeys(os.path.abspath(path) for path in (*sys.path, "")))
