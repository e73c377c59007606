"""Several campaigns in one data set: what each has for itself, and what all share."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import TypeVar, final

T = TypeVar("T")

OWN = ("base.*", "target.*", "socket.*", "ball.*")
"""Parameters that are each session's own unless `[sessions] own` says otherwise: where things were put."""
ON_FLANGE = "tool.*"  # stays where it is between sessions, but not until another campaign
STANDING = "hand_eye.*"  # of a sensor that stands in the cell: likewise
FEWEST_POSES = 3  # poses with points that each session must have: fewer leave the place of its base or target open


def matches(parameter: str, patterns: Iterable[str]) -> bool:
    """Whether one of the patterns is that of a parameter."""
    return any(fnmatchcase(parameter, pattern) for pattern in patterns)


@final
@dataclass(frozen=True)
class Sessions:
    """The sessions of a data set."""

    names: tuple[str, ...]  # in the order in which poses.csv has them; a part of a data set keeps those of the whole
    own: tuple[str, ...] = OWN  # patterns of parameters' names, `*` for any text, of which each session has a copy

    def is_own(self, parameter: str) -> bool:
        """Whether each session has a copy of a parameter."""
        return matches(parameter, self.own)

    def named(self, parameter: str, session: str) -> str:
        """What a sensor's parameter is called in a session: `base.x@SESSION` where it is its own, `tool.a.x` else."""
        return f"{parameter}@{session}" if self.is_own(parameter) else parameter

    def values_in(self, values: Mapping[str, T], session: str) -> dict[str, T]:
        """Values by name as they are in a session, by the names that they have without sessions."""
        others = tuple(f"@{name}" for name in self.names)
        shared = {name: value for name, value in values.items() if not name.endswith(others)}
        here = f"@{session}"
        return shared | {name.removesuffix(here): value for name, value in values.items() if name.endswith(here)}
