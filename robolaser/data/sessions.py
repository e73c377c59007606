"""Several campaigns in one data set: parameters of each, and shared ones."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import TypeVar, final

T = TypeVar("T")

OWN = ("base.*", "target.*", "socket.*", "ball.*")  # parameters of each session by default: positions of equipment
ON_FLANGE = "tool.*"  # constant between sessions, but not between campaigns
STANDING = "hand_eye.*"  # of a sensor that is fixed in the cell: likewise
FEWEST_POSES = 3  # poses with points that each session needs: fewer do not determine the pose of its base or target


def matches(parameter: str, patterns: Iterable[str]) -> bool:
    """Whether one of the patterns is that of a parameter."""
    return any(fnmatchcase(parameter, pattern) for pattern in patterns)


@final
@dataclass(frozen=True)
class Sessions:
    """The sessions of a data set."""

    names: tuple[str, ...]  # in the order of poses.csv; a part of a data set keeps those of the whole
    own: tuple[str, ...] = OWN  # patterns of the names, `*` for any text, of parameters that each session has a copy of

    def is_own(self, parameter: str) -> bool:
        """Whether each session has a copy of a parameter."""
        return matches(parameter, self.own)

    def named(self, parameter: str, session: str) -> str:
        """Name of a sensor's parameter in a session: `base.x@SESSION` where each has a copy, `tool.a.x` else."""
        return f"{parameter}@{session}" if self.is_own(parameter) else parameter

    def values_in(self, values: Mapping[str, T], session: str) -> dict[str, T]:
        """Values in a session, by names without a session."""
        others = tuple(f"@{name}" for name in self.names)
        shared = {name: value for name, value in values.items() if not name.endswith(others)}
        here = f"@{session}"
        return shared | {name.removesuffix(here): value for name, value in values.items() if name.endswith(here)}
