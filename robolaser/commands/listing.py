"""robolaser list: the robots, effects and algorithms that are there."""

import argparse
from collections.abc import Iterable
from typing import ClassVar, final

from robolaser.commands.command import Command


@final
class List(Command):
    """Shows what is there."""

    name: ClassVar[str] = "list"
    summary: ClassVar[str] = "show the robots, effects or algorithms that are there"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        parser.add_argument("family", choices=tuple(FAMILIES), help="what to show")

    def run(self, args: argparse.Namespace) -> None:
        """Print a line for each."""
        rows = list(FAMILIES[args.family]())
        widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
        for row in rows:
            print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def _robots() -> Iterable[tuple[str, ...]]:
    from robolaser.geometry.robots import known_robots  # noqa: PLC0415 - `--help` must not pay for physics

    for robot in known_robots():
        yield robot.name, f"{len(robot.joints)} joints", f"flange {robot.flange}", robot.title


def _effects() -> Iterable[tuple[str, ...]]:
    from robolaser.model.effects import EFFECTS, outliers  # noqa: PLC0415

    for effect in EFFECTS:
        declared = [(name, unit) for name, unit, *_ in effect.declared()]
        shapes = [(name, unit) for name, unit, *_ in effect.shapes()]
        numbers = ", ".join(f"{name} [{unit}]" if unit else name for name, unit in declared + shapes)
        yield effect.name, effect.title, numbers
    yield outliers.NAME, outliers.TITLE, "share of the points"


def _algorithms() -> Iterable[tuple[str, ...]]:
    from robolaser.algorithms.registry import ALGORITHMS, POLISH_ONLY, SCREENING  # noqa: PLC0415
    from robolaser.benchmark.solvers import SOLVERS  # noqa: PLC0415

    for name, title in SOLVERS.items():
        yield name, "calibrate, compare" if name in (SCREENING, *ALGORITHMS) else "compare", title
    yield POLISH_ONLY, "calibrate", "no search: the polish alone, from the nominal values"


FAMILIES = {"robots": _robots, "effects": _effects, "algorithms": _algorithms}
