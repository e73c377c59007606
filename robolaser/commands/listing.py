"""robolaser list: the members of a family, with those of installed packages."""

from collections.abc import Iterable
from typing import Literal

from robolaser.commands.terminal import Terminal, aligned, say


def list_family(
    family: Literal["robots", "effects", "algorithms", "sensors", "importers"], /, *, terminal: Terminal = Terminal()
) -> None:
    """Show the available robots, effects, algorithms, sensors or importers.

    For example:

        robolaser list effects

    Args:
        family: What to show.
    """
    titles, members = FAMILIES[family]
    rows = list(members())
    terminal.show(
        {family: [dict(zip(titles, row, strict=True)) for row in rows]}, lambda: say("\n".join(aligned(rows)))
    )


def _robots() -> Iterable[tuple[str, ...]]:
    from robolaser.robot.by_name import known_robots

    for robot in known_robots():
        yield robot.name, f"{len(robot.joints)} joints", f"flange {robot.flange}", robot.title


def _effects() -> Iterable[tuple[str, ...]]:
    from robolaser.model.effects import EFFECTS, outliers
    from robolaser.motion.effects import MOTION_EFFECTS

    for effect in EFFECTS:
        numbers = ", ".join(f"{name} [{unit}]" if unit else name for name, unit in effect.units().items())
        yield effect.name, effect.title, numbers
    yield outliers.NAME, outliers.TITLE, "share of the points"
    for moving in MOTION_EFFECTS:
        numbers = ", ".join(f"{one.name} [{one.unit}]" if one.unit else one.name for one in moving.numbers)
        yield moving.name, f"moving arm: {moving.clause}", numbers


def _algorithms() -> Iterable[tuple[str, ...]]:
    from robolaser.algorithms.registry import POLISH_ONLY, SCREENING, algorithms
    from robolaser.benchmark.solvers import solver_titles

    for name, title in solver_titles().items():
        yield name, "calibrate, compare" if name in (SCREENING, *algorithms()) else "compare", title
    yield POLISH_ONLY, "calibrate", "no search: the polish alone, from the nominal values"


def _sensors() -> Iterable[tuple[str, ...]]:
    from robolaser.model.sensors import sensors

    for kind, sensor in sensors().items():
        yield kind, sensor.format.title


def _importers() -> Iterable[tuple[str, ...]]:
    from robolaser.data.importers import importers

    for name, importer in importers().items():
        yield name, importer.title, ", ".join(importer.further)


FAMILIES = {  # the columns of each, and the function that yields its rows
    "robots": (("robot", "joints", "flange", "title"), _robots),
    "effects": (("effect", "title", "parameters"), _effects),
    "algorithms": (("algorithm", "commands", "title"), _algorithms),
    "sensors": (("sensor", "title"), _sensors),
    "importers": (("importer", "title", "options"), _importers),
}
