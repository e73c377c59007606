"""A progress bar of long work: in a notebook, or on a terminal."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
from threading import Timer
from typing import Any, Final

from robolaser.arrays import Progress
from robolaser.report.printable import printable

PATIENCE_S: Final = 2.0  # work that takes less time shows no bar
APART_S: Final = 0.2  # least time between two states of a notebook's bar


@contextmanager
def progress_bar() -> Iterator[Progress]:
    """Show the progress of a long call, in a notebook or on a terminal.

    Yields:
        The argument `progress` of `calibrate`, `diagnose` and `compare`: a function of the current step and its
        finished share, 0 to 1.

    Examples:
        >>> with robolaser.progress_bar() as progress:
        ...     found = robolaser.calibrate(dataset, progress=progress)
    """
    if (kernel := _kernel()) is not None:
        yield from _in_notebook(kernel)
    elif sys.stderr.isatty():
        yield from _on_terminal()
    else:
        yield lambda what, share: None


def _kernel() -> Any:
    """The notebook's shell; None outside a notebook, where nothing has imported IPython."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    return shell if hasattr(shell, "kernel") else None


def _in_notebook(shell: Any) -> Iterator[Progress]:
    from IPython.display import HTML, display  # noqa: PLC0415 - only a notebook has it

    began = shown = time.monotonic()
    handle: Any = None

    def show(what: str, share: float) -> None:
        nonlocal handle, shown
        now = time.monotonic()
        if now - began < PATIENCE_S or now - shown < APART_S:
            return
        shown, bar = now, HTML(f"<progress value={share:.3f}></progress> {escape(printable(what))}")
        if handle is None:
            handle = display(bar, display_id=True)
        else:
            handle.update(bar)

    yield show
    if handle is not None:
        handle.update(HTML(""))


def _on_terminal() -> Iterator[Progress]:
    from rich.console import Console  # noqa: PLC0415 - work without a terminal does not pay for it
    from rich.markup import escape as plain  # noqa: PLC0415
    from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn  # noqa: PLC0415
    from rich.progress import Progress as Bar  # noqa: PLC0415

    columns = (BarColumn(30), TaskProgressColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
    bar = Bar(*columns, console=Console(stderr=True), transient=True, refresh_per_second=5)
    task = bar.add_task("", total=None)
    later = Timer(PATIENCE_S, bar.start)  # long work may report nothing in between
    later.daemon = True
    later.start()

    def show(what: str, share: float) -> None:
        bar.update(task, description=plain(printable(what)), total=1.0, completed=share)

    try:
        yield show
    finally:
        later.cancel()
        later.join()
        bar.stop()
