"""Several campaigns in one data set: what each has for itself, and what all share."""

from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import final

OWN = ("base.*", "target.*", "socket.*", "ball.*")
"""Parameters that are each session's own unless `[sessions] own` says otherwise: where things were put."""
FEWEST_POSES = 3
"""Poses with points that each session must have: fewer leave the place of its base or target open."""


@final
@dataclass(frozen=True)
class Sessions:
    """The sessions of a data set.

    Attributes:
        names: In the order in which poses.csv has them; a part of a data set keeps those of the whole.
        own: Patterns of parameters' names, `*` for any text, of which each session has a copy.
    """

    names: tuple[str, ...]
    own: tuple[str, ...] = OWN

    def is_own(self, parameter: str) -> bool:
        """Whether each session has a copy of a parameter."""
        return any(fnmatchcase(parameter, pattern) for pattern in self.own)

    def named(self, parameter: str, session: str) -> str:
        """What a sensor's parameter is called in a session: `base.x@SESSION` where it is its own, `tool.a.x` else."""
        return f"{parameter}@{session}" if self.is_own(parameter) else parameter
