"""Words for classes of causes and their members in reports."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Final

from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.sensor_sites import kind_of_site, of_sensor

NOUNS: Final[Mapping[str, str]] = {
    "arm_geometry": "the arm's geometry",
    "transmission": "the joints' gears and encoders",
    "elasticity": "elastic deflection under load",
    "thermal": "warming up",
    "timing": "the timing of exposure and joint reading",
    "mount": "the mount on the flange",
    "base": "the supports of base, target and measuring system",
    "camera": "the lens",
    "laser": "the laser plane",
    "target": "the target",
    "measuring_system": "the measuring system",
    "repeatability": "scatter of whole poses",
    "unknown": "a cause that no effect of the library describes",
}
PARTS: Final = frozenset(
    ("base", "camera", "flange", "hand_eye", "image", "laser", "measuring_system", "target", "timing", "tool")
)
"""Sites other than joints."""
NAMED: Final = 3
"""Most effects, classes, sets or poses that a sentence names: the rest are counted. Of so many joints, or more, only
the first has its whole name."""


def spoken(name: str) -> str:
    """A name in words: "hand-eye sag", "Coulomb friction"."""
    for part, word in (("hand_eye", "hand-eye"), ("coulomb", "Coulomb"), ("stribeck", "Stribeck")):
        name = name.replace(part, word)
    return name.replace("_", " ")


def sentence_case(text: str) -> str:
    """Text with a capital letter first."""
    return text[:1].upper() + text[1:]


def noun(name: str) -> str:
    """A class of causes as the subject of a sentence."""
    return NOUNS.get(name, spoken(name))


def place(site: str) -> str:
    """A site in words: "hand-eye"; of one of several sensors "laser of left"; a joint by its name."""
    kind = kind_of_site(site)
    words = spoken(kind) if kind in ("hand_eye", "measuring_system") else kind
    return words if kind == site else f"{words} of {site.removesuffix(f'.{kind}')}"


def site_phrase(site: str) -> str:
    """A site within a sentence: "the hand-eye", but "joint_3"."""
    return f"the {place(site)}" if kind_of_site(site) in PARTS else place(site)


def named(one: CandidateEffect) -> str:
    """An effect with its location: "joint offset of joint_3", or "laser roll"."""
    return members([one])


def members(effects: Iterable[CandidateEffect]) -> str:
    """Effects, those of one kind together: "link geometry of joint_2, 3 and 5, and latency"."""
    ordered = sorted(effects, key=lambda one: one.effect.name)
    return listed([_of(list(some)) for _, some in groupby(ordered, key=lambda one: one.effect.name)])


def pairs_in_words(pairs: Iterable[Sequence[str]]) -> str:
    """Effects by their names and sites in a result's JSON, see `members`; "nothing" if there are none."""
    sites: dict[str, list[str]] = {}
    for effect, site in pairs:
        sites.setdefault(spoken(effect), []).extend([] if site in PARTS else [site])
    words = [f"{one} of {joint_names(sorted(own, key=_number))}" if own else one for one, own in sites.items()]
    return listed(words) or "nothing"


def listed(items: Sequence[str]) -> str:
    """Items with commas and an "and"."""
    if len(items) < 2:
        return "".join(items)
    comma = "," if len(items) > 2 or any(" and " in item or "," in item for item in items) else ""
    return f"{', '.join(items[:-1])}{comma} and {items[-1]}"


def _of(same: Sequence[CandidateEffect]) -> str:
    effect = same[0].effect
    name = spoken(effect.name)
    if not effect.site:
        return f"{name} of {joint_names(sorted((one.where for one in same), key=_number))}"
    own = [one.where.removesuffix(f".{effect.site}") for one in same if of_sensor(one.where)]
    return f"{name} of {listed(sorted(own))}" if own else name


def _number(joint: str) -> tuple[str, int, str]:
    """Sort key: joint_10 after joint_9."""
    stem = joint.rstrip("0123456789")
    return stem, len(joint), joint


def joint_names(names: Sequence[str]) -> str:
    """Names of joints, after the first only their numbers if nothing else differs: "panda_joint2, 3 and 6"."""
    stem = names[0].rstrip("0123456789")
    rests = [name.removeprefix(stem) for name in names]
    is_short = len(names) >= NAMED and stem and all(rest.isdigit() for rest in rests)
    shown = [names[0], *rests[1:]] if is_short else list(names)
    return shown[0] if len(shown) == 1 else f"{', '.join(shown[:-1])} and {shown[-1]}"
