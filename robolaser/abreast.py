"""The same for many things, some of them at a time: NumPy and the compiled loops let go of Python's lock."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

from robolaser.compiled import cores

Thing = TypeVar("Thing")
Result = TypeVar("Result")


def abreast(work: Callable[[Thing], Result], things: Sequence[Thing]) -> Iterator[Result]:
    """What comes of each, in their order: the same to the last bit on however many cores.

    The work must not call this in turn: it would wait for itself.
    """
    if len(things) < 2 or cores() < 2:
        yield from map(work, things)
    else:
        yield from _threads(os.getpid()).map(work, things)


@cache
def _threads(process: int) -> ThreadPoolExecutor:
    """The threads of a process; one that was forked off needs its own."""
    return ThreadPoolExecutor(cores(), thread_name_prefix="robolaser-blocks")
