"""When compiled loops take over from NumPy: after work enough to pay for them, and once they are on disk."""

import importlib.util
import os
import subprocess
import sys
import time
from functools import cache
from importlib import import_module
from typing import Any, final

from robolaser.compiled.kept import folder

GIVEN_UP_AFTER_S = 600.0  # who is still compiling then was killed
SWITCH = "ROBOLASER_COMPILE"
"""Environment variable: `0` does without the compiler; `1` compiles at once and uses the loops for work of any size."""


def compiles() -> str:
    """`0`, `1`, or `auto`: see `SWITCH`; `0` also where numba is not installed."""
    return os.environ.get(SWITCH, "auto") if _has_numba() else "0"


@cache
def _has_numba() -> bool:
    return importlib.util.find_spec("numba") is not None


@final
class Loops:
    """The compiled loops of one module, which declares `warm_up()`: it calls each of them once, with few numbers.

    Args:
        module: Its full name, `robolaser.….…_loops`.
        pays_after: Work, in the caller's units, that NumPy does in about two seconds: to load numba takes one.
    """

    def __init__(self, module: str, *, pays_after: float) -> None:
        self._module, self._pays_after = module, pays_after
        self._done = 0.0
        self._decided = False
        self._loops: Any = None
        self._compiling: subprocess.Popen[bytes] | None = None

    def after(self, work: float) -> Any:
        """The module of loops to do this work with, or None where NumPy does it.

        The decision is made once a process. Where the machine code is not on disk, another process makes it for later.
        """
        mode = compiles()
        if mode == "0":
            return None
        if mode == "1":
            return import_module(self._module)
        self._done += work
        if self._done >= self._pays_after and not self._decided:
            self._decided = True
            self._loops = self._made()
        return self._loops

    def _made(self) -> Any:
        try:
            if ready(self._module):
                return import_module(self._module)
            self._compiling = subprocess.Popen(
                [sys.executable, "-P", "-m", "robolaser.compiled", self._module],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        except OSError:
            pass  # no folder to keep machine code in, or no process to be had: NumPy goes on
        return None


def ready(module: str) -> bool:
    """Whether the machine code of a module is on disk.

    Raises:
        OSError: There is no folder to keep it in.
    """
    return (folder() / f"{module}.ready").exists()


def compile_now(module: str) -> None:
    """Compile the loops of a module and keep them; once, whoever asks.

    Raises:
        OSError: There is no folder to keep them in.
    """
    mark = folder() / f"{module}.compiling"
    if mark.exists() and time.time() - mark.stat().st_mtime > GIVEN_UP_AFTER_S:
        mark.unlink(missing_ok=True)
    try:
        os.close(os.open(mark, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return
    try:
        import_module(module).warm_up()
        (folder() / f"{module}.ready").touch()
    finally:
        mark.unlink(missing_ok=True)
