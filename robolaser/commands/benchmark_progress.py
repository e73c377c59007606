"""Progress of a benchmark, what runs now and how long it will take, on a terminal and only there."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from robolaser.benchmark.run_loop import RunProgress

SHOWN = 4
"""Runs under way that a line has room for."""


@contextmanager
def benchmark_progress() -> Iterator[Callable[[RunProgress], None]]:
    """Show how far a benchmark is, on a terminal and only there."""
    columns = (
        BarColumn(30),
        MofNCompleteColumn(),
        TextColumn("runs"),
        TimeElapsedColumn(),
        TextColumn("{task.fields[left]}"),
        TextColumn("{task.description}", style="dim"),
    )
    console = Console(stderr=True)
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("starting", total=None, left="")

        def show(progress: RunProgress) -> None:
            running = "; ".join(
                f"{one.algorithm} on {one.problem}, seed {one.seed}" for one in progress.running[:SHOWN]
            )
            running = running or "waiting for the first worker"
            bar.update(
                task, completed=progress.done, total=progress.wanted, description=running, left=_left(progress.left_s)
            )

        yield show


def _left(seconds: float | None) -> str:
    """Remaining time in words."""
    if seconds is None:
        return ""
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes // 60} h {minutes % 60} min left" if minutes >= 60 else f"{minutes}:{seconds:02d} left"
