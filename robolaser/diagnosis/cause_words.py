"""Classes of causes and their members in words that people at a robot use."""

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
    "mount": "the sensor's mount",
    "base": "the supports of base and target",
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
"""Sites that are no joints."""
FEW: Final = 3
"""Names from which on those of joints are shortened."""


def spoken(name: str) -> str:
    """A name in words: "hand-eye sag", "Coulomb friction"."""
    for part, word in (("hand_eye", "hand-eye"), ("coulomb", "Coulomb"), ("stribeck", "Stribeck")):
        name = name.replace(part, word)
    return name.replace("_", " ")


def sentence_case(text: str) -> str:
    """Text as a sentence begins."""
    return text[:1].upper() + text[1:]


def noun(name: str) -> str:
    """A class of causes as the subject of a sentence."""
    return NOUNS.get(name, spoken(name))


def place(site: str) -> str:
    """A site as people call it, one of several sensors with its name: "laser of left"; a joint as it is named."""
    kind = kind_of_site(site)
    said = spoken(kind) if kind in ("hand_eye", "measuring_system") else kind
    return said if kind == site else f"{said} of {site.removesuffix(f'.{kind}')}"


def site_phrase(site: str) -> str:
    """The same in a sentence: "the hand-eye", but "joint_3"."""
    return f"the {place(site)}" if kind_of_site(site) in PARTS else place(site)


def named(one: CandidateEffect) -> str:
    """An effect at its place: "joint offset of joint_3", or "laser roll"."""
    return members([one])


def members(effects: Iterable[CandidateEffect]) -> str:
    """Effects, those of one kind together: "link geometry of joint_2, 3 and 5, and latency"."""
    ordered = sorted(effects, key=lambda one: one.effect.name)
    return listed([_of(list(some)) for _, some in groupby(ordered, key=lambda one: one.effect.name)])


def pairs_in_words(pairs: Iterable[Sequence[str]]) -> str:
    """The same of names of effects and their sites, as a result's JSON has them; "nothing" where there are none."""
    sites: dict[str, list[str]] = {}
    for effect, site in pairs:
        sites.setdefault(spoken(effect), []).extend([] if site in PARTS else [site])
    said = [f"{one} of {joint_names(sorted(own, key=_number))}" if own else one for one, own in sites.items()]
    return listed(said) or "nothing"


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
    """Sorts joint_10 behind joint_9."""
    stem = joint.rstrip("0123456789")
    return stem, len(joint), joint


def joint_names(names: Sequence[str]) -> str:
    """Names of joints, the numbers alone after the first where nothing else differs: "panda_joint2, 3 and 6"."""
    stem = names[0].rstrip("0123456789")
    rests = [name.removeprefix(stem) for name in names]
    is_short = len(names) >= FEW and stem and all(rest.isdigit() for rest in rests)
    shown = [names[0], *rests[1:]] if is_short else list(names)
    return shown[0] if len(shown) == 1 else f"{', '.join(shown[:-1])} and {shown[-1]}"
