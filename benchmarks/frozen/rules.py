"""Rules by which the diagnosis gives names up, each of which can be left out to see what it is worth."""

from collections.abc import Callable
from typing import Any, Final

from robolaser.diagnosis import pruning
from robolaser.diagnosis.posture_rivals import PostureRivals
from robolaser.diagnosis.refits import Refits

RULES: Final[dict[str, tuple[Any, str, Callable[..., Any]]]] = {
    "unknown at a joint": (Refits, "locally_unmodelled", lambda *_: 0.0),
    "unknown of several joints": (PostureRivals, "unmodelled", lambda *_: 0.0),
    "simple shapes": (Refits, "_sparsely_unmodelled", lambda *_: 0.0),
    "aliases": (pruning, "aliases", lambda *_: []),
    "credibility": (pruning, "_incredible", lambda *_: []),
}
"""Where each is, and what stands in its place: no cause but the named ones, no doubt."""


def leave_out(rule: str) -> None:
    """Diagnose without a rule from now on, in this process."""
    owner, name, nothing = RULES[rule]
    assert hasattr(owner, name)
    setattr(owner, name, nothing)
