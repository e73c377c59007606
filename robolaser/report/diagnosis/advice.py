"""What to beware of with an effect that was found, and what to do about it."""

from collections.abc import Mapping

from robolaser.diagnosis.result import Alternative, Diagnosis, Estimate, Finding
from robolaser.diagnosis.summary_text import EVEN

SURE = 0.95
"""Probability below which a finding is called a likelihood."""
CLEAR = 2.0
"""Standard deviations from zero, below which a number may as well be none."""
ALIKE = 0.5
"""Share relative to the largest, from which on a place is worth a look too."""
WORSE = 1.02
"""Held-out gap over that of what was found, from which on a rival does worse."""
FEW = 2
"""Rivals that a caveat names."""

SITES: Mapping[str, str] = {
    "camera": "the lens and how it is fixed",
    "laser": "the projector: its mount, its warm-up, its focus",
    "hand_eye": "the bracket between flange and scanner",
    "target": "the target: flatness, print, fixing",
    "base": "what base and target stand on",
    "timing": "how camera and joint readings are synchronised",
    "image": "single images, and how the stripe is found in them",
    "tool": "how ball or reflectors are fixed to the flange",
}
"""What to look at, by the site where something unexplained lies; a joint is a joint."""


def caveats(diagnosis: Diagnosis, found: Finding) -> list[str]:
    """What to beware of with an effect, the gravest first; never nothing."""
    said = []
    if found.alternatives:
        others = [str(rival.candidate_effect) for rival in found.alternatives[:FEW]]
        more = len(found.alternatives) - len(others)
        said.append(f"these poses cannot tell it from {', '.join(others)}" + (f" and {more} more" if more else ""))
    if found.probability < SURE:
        said.append("likely rather than sure")
    if diagnosis.verdict == "unexplained":
        said.append("may have taken a part of what is unexplained")
    return [*said, found.candidate_effect.effect.caveat]


def beside(found: Finding, rival: Alternative) -> str:
    """What to beware of with a rival: how it compares with what was found in its place."""
    more = len(rival.parameters) - len(found.parameters)
    worse = rival.gap_m > WORSE * found.gap_after_m
    said = [f"has {more} more number{'s' * (more > 1)} to fit with"] if more > 0 else []
    said += ["predicts new poses less well"] if worse else []
    return "; ".join(said) or "predicts new poses as well: only other poses decide"


def doubt(number: Estimate) -> str:
    """What to beware of with one number; may be empty."""
    if number.std is None:
        return "not fixed by these data"
    return "may as well be zero" if abs(number.value) < CLEAR * number.std else ""


def to_do(diagnosis: Diagnosis) -> list[str]:
    """What to do next, most useful first."""
    said = []
    for found in diagnosis.findings:
        remedy = found.candidate_effect.remedy
        if found.probability < EVEN:
            remedy = "Do not mend it yet: something else is likelier."
        said.append(f"{found.candidate_effect}: {remedy}")
    if diagnosis.verdict == "unexplained":
        said.append(_look(diagnosis))
    if diagnosis.next_poses:
        said.append(_measure(diagnosis))
    if len(diagnosis.outliers):
        said.append("Look at the images of the gross errors listed below; they count for nothing here.")
    if diagnosis.findings:
        said.append("Until then use the corrected model, `calibration.json`: it has all the effects found.")
    if diagnosis.verdict == "no_gap":
        said.append(
            "Nothing needs mending. To become more accurate than this, lower the noise: repeat shots, or find the"
            " stripe better."
        )
    return said


def _look(diagnosis: Diagnosis) -> str:
    if not diagnosis.where:
        return "The rest lies at no one place. More poses, spread wider, may show where."
    largest = diagnosis.where[0].share
    alike = {lies.site: lies.coordinate for lies in reversed(diagnosis.where) if lies.share >= ALIKE * largest}
    sites = list(reversed(alike))
    looked = "; and at ".join(SITES.get(site, f"{site}: gear, encoder and bearings") for site in sites)
    follows = ", ".join(dict.fromkeys(alike[site] for site in sites))
    return (
        f"Look at {looked}. What is left there follows: {follows}; but in no form that an effect of the library has."
        " One of your own may."
    )


def _measure(diagnosis: Diagnosis) -> str:
    count = len(diagnosis.next_poses)
    poses = "the pose" if count == 1 else f"the {count} poses"
    torn = next((found for found in diagnosis.findings if found.alternatives), None)
    if torn is None:
        return f"Measure {poses} listed below: they would tell most."
    rival = torn.alternatives[0].candidate_effect
    return f"Measure {poses} listed below: they distinguish {torn.candidate_effect} from {rival}."
