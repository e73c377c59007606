"""How a loop is compiled: without Python's lock, and kept on disk in a folder of its source's version."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numba

from robolaser.compiled.kept import folder

MADE_FREELY = {"contract", "reassoc"}  # sums may be taken in any order and products fused; what is not finite stays so


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function of arrays and numbers when it is first called."""
    return _made(function, fastmath=MADE_FREELY)


def compiled_exactly(function: Callable[..., Any]) -> Callable[..., Any]:
    """The same without any freedom: sums in their order, products and sums each rounded."""
    return _made(function)


def _made(function: Callable[..., Any], **freedom: Any) -> Callable[..., Any]:
    how: dict[str, Any] = {"nogil": True, "error_model": "numpy", **freedom}
    try:
        with _kept_in(str(folder())):
            made: Callable[..., Any] = numba.njit(cache=True, **how)(function)
    except (RuntimeError, OSError):  # the folder cannot be written
        made = numba.njit(**how)(function)
    return made


@contextmanager
def _kept_in(path: str) -> Iterator[None]:
    """Numba's cache at a path, for functions declared meanwhile."""
    before = numba.config.CACHE_DIR  # type: ignore[attr-defined]
    numba.config.CACHE_DIR = path  # type: ignore[attr-defined]
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before  # type: ignore[attr-defined]
