"""A run in a process of its own, guarded from outside: if it hangs, dies or eats memory, that costs nobody else."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import final

from robolaser.benchmark.payload import Task
from robolaser.benchmark.single_run import Run
from robolaser.benchmark.worker import BEGUN, NEEDED, READY

GRACE_S = 5.0
"""A run that is out of time is told so at its next evaluation; one that has not come back by then is killed."""
PATIENCE_S = 120.0
"""For imports and the question, on a machine that has much else to do."""
COMPILING_S = 60.0
"""More than a run may take, the uncounted first one may: loops are compiled in it that no process has compiled yet."""
ATTEMPTS = 2
"""A child that was killed from outside is no fault of the run's; one that dies again is."""
_LONGEST_S = 1e6  # that the system can be asked to wait for

_ENVIRONMENT = {
    **{f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "NUMBA", "NUMEXPR")},
    "VECLIB_MAXIMUM_THREADS": "1",
    "PYTHONHASHSEED": "0",  # the order of sets is the same everywhere
}


@final
@dataclass(frozen=True)
class Origin:
    """From where tasks come.

    Attributes:
        name: Unique.
        paths: Where modules are looked for there; children look there too, last.
    """

    name: str
    paths: tuple[str, ...]

    @classmethod
    def here(cls) -> "Origin":
        """This process, now."""
        return cls(uuid.uuid4().hex, _paths())


class Hung(Exception):
    """A child did not come back in time."""

    def __init__(self, allowed_s: float) -> None:
        super().__init__(allowed_s)
        self.allowed_s = allowed_s


@final
class Child:
    """A process that makes one run after the other, and does not outlive this one.

    Attributes:
        began: When the clock of the present run began, `time.monotonic`; None before.
        heard: Whether it has said a word on the present run.
    """

    def __init__(self) -> None:
        talk, its_talk = socket.socketpair()
        its_life, life = os.pipe()  # nothing is ever said on it; that it breaks says all
        with its_talk:
            fds = its_talk.fileno(), its_life
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "robolaser.benchmark.worker", *map(str, fds)],
                pass_fds=fds,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
                env=os.environ | _ENVIRONMENT | {"PYTHONPATH": os.pathsep.join(_paths())},
            )
        self._talk, self._life = Connection(talk.detach()), Connection(life, readable=False)
        os.close(its_life)
        self.began: float | None = None
        self.heard = False

    @property
    def alive(self) -> bool:
        """Whether it still runs."""
        return self._process.poll() is None

    def run(
        self, task: Task, digest: str, payload: Callable[[], bytes], origin: Origin, *, warm_up: bool
    ) -> tuple[Run, bool]:
        """Let it make a run; also say whether it is fit for another.

        Raises:
            Hung: It did not come back.
            EOFError, OSError: It died.
        """
        self.began, self.heard = None, False
        self._talk.send((task, digest, origin.paths, warm_up))
        allowed_s = PATIENCE_S
        while self._talk.poll(min(allowed_s, _LONGEST_S)):
            said = self._talk.recv()
            self.heard = True
            if said == NEEDED:
                self._talk.send_bytes(payload())
            elif said == READY:
                allowed_s = task.time_limit_s + GRACE_S + COMPILING_S
            elif said == BEGUN:
                self.began = time.monotonic()
                allowed_s = task.time_limit_s + GRACE_S
            else:
                run, fit = said
                return run, fit
        raise Hung(allowed_s)

    def kill(self) -> str:
        """End it and all that it started, and say what it died of if it was dead before."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(0.2)
        code = self._process.poll()
        self.end()
        if code is None:
            return "it cut the line to its process; killed"
        if code >= 0:
            return f"it ended its process, with exit code {code}"
        with suppress(ValueError):
            said = "killed from outside or out of memory" if -code == signal.SIGKILL else signal.Signals(-code).name
            return f"its process died (signal {-code}, {said})"
        return f"its process died (signal {-code})"

    def end(self) -> None:
        """End it and all that it started, at once; from any thread, so the lines to it are left to who may use them."""
        with suppress(OSError):  # nobody is left of its group
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()


_children: dict[tuple[str, int], Child] = {}
_hung: set[tuple[str, str]] = set()
_ended: set[str] = set()


def guarded(task: Task, digest: str, payload: Callable[[], bytes], origin: Origin) -> Run:
    """Make a run in this thread's child, which is kept for the next.

    Args:
        task: What is to be run.
        digest: By which the child knows the question.
        payload: Gives the pickled source of the question; called only if the child does not have it.
        origin: Of the task.

    Returns:
        The run; a failed one if the child did not come back, or died and did so again when it was tried once more.
    """
    mine = origin.name, threading.get_ident()
    pair = digest, task.algorithm
    reason, seconds = "stopped", 0.0
    left = ATTEMPTS
    while left:
        child = _children.get(mine)
        kept = child is not None and child.alive
        if child is None or not kept:
            _forget(mine)
            child = _children[mine] = Child()
        if origin.name in _ended:
            _forget(mine)
            break
        sent = time.monotonic()
        try:
            run, fit = child.run(task, digest, payload, origin, warm_up=pair not in _hung)
        except Hung as hung:
            if child.began is None:
                _hung.add(pair)  # its next run need not be waited for that long
            _forget(mine)
            where = "" if child.began else " of its uncounted first evaluations"
            reason = f"never came back within {hung.allowed_s:g} s{where}; killed"
            return task.failed(reason, seconds=time.monotonic() - (child.began or sent))
        except (EOFError, OSError):
            reason, seconds = child.kill(), time.monotonic() - (child.began or sent)
            _children.pop(mine, None)
            left -= not kept or child.heard  # it may have died of the last run, or between the two
            continue
        if not fit:
            _forget(mine)
        return run
    return task.failed(reason, seconds=seconds)


def end(name: str) -> None:
    """End at once all children that make runs for an origin of that name, for good."""
    _ended.add(name)
    for mine in list(_children):
        if mine[0] == name:
            _forget(mine)


def _forget(mine: tuple[str, int]) -> None:
    child = _children.pop(mine, None)
    if child is not None:
        child.end()


def _paths() -> tuple[str, ...]:
    return tuple(os.path.abspath(path) for path in sys.path)
