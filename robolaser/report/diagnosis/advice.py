"""What to beware of with an effect that was found, and what to do about it."""

from collections.abc import Mapping
from typing import Final

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

CAVEATS: Mapping[str, str] = {
    "joint_offset": "counts from the zero that the robot's controller was given",
    "link_geometry": "numbers that turn about or slide along the joint's own axis are another's offset",
    "joint_compliance": "scales with the URDF's masses: an arm 10 % heavier than said makes it 10 % too large",
    "backlash": "takes for granted that the arm came straight from the pose before",
    "transmission_error": "its frequency is one of several that were tried",
    "encoder_scale": "seen only over the angles that these poses span",
    "encoder_eccentricity": "seen only over the angles that these poses span",
    "base_shift": "robot and target look the same from here: either may have moved",
    "thermal_drift": "holds for a warm-up like this one",
    "hand_eye_drift": "holds for a run like this one",
    "latency": "takes the velocities in the data for those at the exposure",
    "radial_distortion": "believe it where the stripe was seen, not in the image's corners",
    "laser_curvature": "believe it where the stripe was seen, not beyond",
    "laser_drift": "holds for a warm-up like this one",
    "stripe_bias": "holds for this target's surface",
    "target_warp": "its height is known where points were seen, not beyond",
}
CAVEAT: Final = "holds for poses like the ones measured"
"""Of an effect that has no words of its own."""

REMEDIES: Mapping[str, str] = {
    "joint_offset": "Set the zero of {where} anew, or use `robot_corrected.urdf`, which has it.",
    "link_geometry": "Use `robot_corrected.urdf`: it has {where} where it was found.",
    "joint_compliance": "Carry less, or correct the angle of {where} for what it bears.",
    "backlash": "Come to each pose of {where} from the same side, or have its gear adjusted.",
    "transmission_error": "Correct {where} by the model, or have its gear looked at.",
    "encoder_scale": "Correct the gear ratio or the counts per turn of {where}.",
    "encoder_eccentricity": "Correct {where} by the model, or have its encoder centred.",
    "base_shift": "See what is loose: clamp base and target, and measure again.",
    "thermal_drift": "Let the arm warm up before measuring, or correct for the temperature.",
    "hand_eye_drift": "Tighten the scanner's bracket, or calibrate at shorter intervals.",
    "latency": "Trigger the camera and read the joints together, or stand still at each exposure.",
    "radial_distortion": "Use the lens as found here: `camera.yaml` has it.",
    "tangential_distortion": "Use the lens as found here: `camera.yaml` has it.",
    "laser_curvature": "Use the corrected model: a bent sheet cannot be mended by turning it.",
    "laser_roll": "Turn the projector in its mount, or use the corrected model.",
    "laser_drift": "Switch the projector on well before measuring.",
    "stripe_bias": "Look at surfaces squarely, expose shorter, or use a duller target.",
    "target_scale": "Measure the target with a caliper: its squares are not what the data set says.",
    "target_warp": "Use a stiffer target, or glue it to glass.",
}
REMEDY: Final = "Use the corrected model."
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
        others = [
            f"{rival.candidate_effect.kind.name} at {rival.candidate_effect.where}"
            for rival in found.alternatives[:FEW]
        ]
        more = len(found.alternatives) - len(others)
        said.append(f"these poses cannot tell it from {', '.join(others)}" + (f" and {more} more" if more else ""))
    if found.probability < SURE:
        said.append("likely rather than sure")
    if diagnosis.verdict == "unexplained":
        said.append("may have taken a part of what is unexplained")
    return [*said, CAVEATS.get(found.candidate_effect.kind.name, CAVEAT)]


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
        remedy = REMEDIES.get(found.candidate_effect.kind.name, REMEDY).format(where=found.candidate_effect.where)
        if found.probability < EVEN:
            remedy = "Do not mend it yet: something else is likelier."
        said.append(f"{found.candidate_effect.kind.name} at {found.candidate_effect.where}: {remedy}")
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
    return (
        f"Measure {poses} listed below: they tell {torn.candidate_effect.kind.name} at {torn.candidate_effect.where} from"
        f" {rival.kind.name} at {rival.where}."
    )
