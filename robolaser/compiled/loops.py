"""How loops are compiled: without Python's lock, and kept on disk from one run to the next.

What is kept is made anew when the file of a function changes, but not when a function or a number in another file does
that it takes from there: after such a change, delete `__pycache__/*.nb?`.
"""

import sys
from collections.abc import Callable
from typing import Any, final

import numba
from numba.core import event

MADE_FREELY = {"contract", "reassoc"}
"""Sums may be taken in any order and products fused; what is not finite stays so."""


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function of arrays and numbers when it is first called."""
    return _made(function, fastmath=MADE_FREELY)


def compiled_exactly(function: Callable[..., Any]) -> Callable[..., Any]:
    """The same without any freedom: sums in their order, products and sums each rounded."""
    return _made(function)


def _made(function: Callable[..., Any], **freedom: Any) -> Callable[..., Any]:
    how: dict[str, Any] = {"nogil": True, "error_model": "numpy", **freedom}
    try:
        made: Callable[..., Any] = numba.njit(cache=True, **how)(function)
    except RuntimeError:  # nowhere to keep it: neither beside the package nor in the user's folder may be written
        made = numba.njit(**how)(function)
    return made


@final
class _Announcement(event.Listener):
    """Says, on a terminal, why the first run waits."""

    def __init__(self) -> None:
        self.made = False

    def on_start(self, event: Any) -> None:
        """Something is about to be compiled that is not on disk."""
        if not self.made and sys.stderr.isatty():
            print("Compiling for this machine, once: up to half a minute.", file=sys.stderr)
        self.made = True

    def on_end(self, event: Any) -> None:
        """Nothing to say."""


event.register("numba:compile", _Announcement())  # type: ignore[no-untyped-call]
