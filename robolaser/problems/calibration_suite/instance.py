"""What the suite says of an instance: its data, its variables, and the best that is known of it."""

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import final

import msgspec

from robolaser.errors import UsageError, near

FOLDER = Path(__file__).parent
DATA, TABLE = FOLDER / "data", FOLDER / "instances.toml"


@final
@dataclass(frozen=True)
class Instance:
    """A data set, seen through a model, and its lowest known J."""

    id: str
    title: str
    data: str  # the data set's folder
    effects: tuple[str, ...] = ()  # that the model has beside the sensor, as `--with` takes them
    held: tuple[str, ...] = ()  # parameters that stay at their nominal values
    reduced: bool = False  # without the parameters that follow from the others in closed form
    best: float = float("inf")  # lowest J that anybody found; m², of cameras px²
    best_x: tuple[float, ...] = ()  # where that is
    starts: int = 0  # descents that were made, from starts that are uniform within the bounds
    reached: int = 0  # of them that ended within one per cent of the lowest J


@cache
def instances() -> dict[str, Instance]:
    """All of them, by id, in their order."""
    found = tomllib.loads(TABLE.read_text(encoding="utf-8"))
    return {name: msgspec.convert({"id": name, **entry}, Instance) for name, entry in found.items()}


def instance_named(name: str) -> Instance:
    """The instance of this id.

    Raises:
        UsageError: There is none.
    """
    if name not in instances():
        raise UsageError(f"The suite has no instance '{name}'.{near(name, list(instances()))}")
    return instances()[name]
