"""Robots by what people call them: makers, blanks, dashes and capitals do not matter, and no arm stands for another."""

import difflib
import re
from collections.abc import Iterable, Mapping, Sequence

MOST_NAMED = 6
SIMILAR = 0.55  # similarity of two names, as `difflib` measures it, from which on one may be meant by the other
LONG = 5
"""Letters of a family's name, from which on some may be wrong: of two or three, any other makes it another maker's."""
SLIP = 0.75  # similarity from which on a family's long name may be misspelt: two letters exchanged in five


def plain(name: str) -> str:
    """A name without blanks, dashes, slashes and capitals: "KR 6 R900-sixx" -> "kr6r900sixx"."""
    return re.sub(r"[^a-z0-9]", "", name.casefold())


def without_maker(name: str, makers: Iterable[str]) -> str:
    """A plain name without the words of its maker: "Universal Robots UR5e" -> "ur5e"."""
    words = re.findall(r"[a-z0-9]+", name.casefold())
    spoken = {word for maker in makers for word in maker.casefold().split()}
    return "".join(word for word in words if word not in spoken)


def match(name: str, known: Mapping[str, Sequence[str]], makers: Sequence[str]) -> str | None:
    """The robot that is called so; None where none is.

    Args:
        name: What was typed.
        known: The names that each robot goes by.
        makers: Of all robots.
    """
    for spelled in (plain(name), without_maker(name, makers)):
        for robot, names in known.items():
            if spelled in map(plain, names):
                return robot
    return None


def nearest(name: str, known: Mapping[str, Sequence[str]], makers: Sequence[str]) -> list[str]:
    """Robots that may have been meant, the likeliest first: of the same family of names, or nearly spelled so."""
    typed = without_maker(name, makers) or plain(name)
    scores = {
        robot: max(
            (
                difflib.SequenceMatcher(None, typed, other).ratio()
                for other in map(plain, names)
                if _may_be(_family(typed), _family(other))
            ),
            default=0.0,
        )
        for robot, names in known.items()
    }
    likely = sorted((robot for robot in scores if scores[robot] >= SIMILAR), key=lambda robot: -scores[robot])
    return likely[:MOST_NAMED]


def _family(name: str) -> str:
    found = re.match(r"[a-z]+", name)
    return found[0] if found else ""


def _may_be(typed: str, family: str) -> bool:
    if typed == family:
        return True
    long = min(len(typed), len(family)) >= LONG
    return long and difflib.SequenceMatcher(None, typed, family).ratio() >= SLIP
