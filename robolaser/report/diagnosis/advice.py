"""Caveats about the effects found, and remedies."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from robolaser.calibration.contradicted_distance import ContradictedDistance
from robolaser.diagnosis.candidate_sites import FORCE
from robolaser.diagnosis.cause_classes import class_of, unknown_instead
from robolaser.diagnosis.cause_words import joint_names, listed, named, noun, sentence_case
from robolaser.diagnosis.corrected_model import given_on_bound
from robolaser.diagnosis.gross_errors import outlying_poses, shortened
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.pose_scatter import BY_CHANCE
from robolaser.diagnosis.result import Diagnosis, Estimate, Finding
from robolaser.estimation.certainty import CERTAIN
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.sensor_sites import kind_of_site
from robolaser.report.digits import millimetres, plain

CLEAR = 2.0  # standard deviations from zero below which a value may be zero
UNDETERMINED = "not determined by these data"
ALIKE = 0.5  # share relative to the largest above which a site is worth checking too
FEW = 2  # alternatives that a caveat names

_DIAGNOSE_AGAIN = "No effect was looked for: correct what the first sentence states, then diagnose again."

_STAND_STILL = (
    "Record the measured joint angles, not the commanded ones, and only after the arm has stopped. Then return to some"
    " poses several times from elsewhere, each return as a pose of its own: that shows the repeatability."
)

SITES: Mapping[str, str] = {  # what to check at a site with an unexplained error; a joint is named
    "camera": "the lens and how it is fixed",
    "laser": "the projector: its mount, its warm-up, its focus",
    "hand_eye": "the bracket between flange and sensor",
    "target": "the target: flatness, print, fixing",
    "base": "the supports of base, target and measuring system",
    "timing": "how camera and joint readings are synchronised",
    "image": "single images, and how the stripe is found in them",
    "tool": "how ball or reflectors are fixed to the flange",
    "measuring_system": "the measuring system: its scale, its mount",
}


def caveats(found: Finding) -> list[str]:
    """Caveats about an effect, the most serious first; at least one."""
    lower = {each.name: each.lower for each in found.candidate_effect.effect.amplitudes()}
    notes = [
        f"{name} ended on its {number.bound} bound, {plain(number.value, number.unit, 3)}:"
        " the cause is larger, or another one"
        for name, number in found.parameters.items()
        if name in lower and (number.bound == "upper" or (number.bound == "lower" and lower[name] < 0.0))
    ]
    is_certain = found.probability >= CERTAIN
    if found.alternatives:
        others = [named(other.candidate_effect) for other in found.alternatives[:FEW]]
        left = len(found.alternatives) - len(others)
        more = f" and {left} more" if left else ""
        what = "less probable alternatives:" if is_certain else "these poses cannot distinguish it from"
        notes.append(f"{what} {', '.join(others)}{more}")
    elif not is_certain:
        notes.append("not certain individually")
    return [*notes, found.candidate_effect.effect.caveat]


def doubt(number: Estimate) -> str:
    """The caveat about one value; may be empty."""
    if number.bound:
        return f"on its {number.bound} bound"
    if number.std is None:
        return UNDETERMINED
    return "may be zero" if abs(number.value) < CLEAR * number.std else ""


def to_do(diagnosis: Diagnosis) -> list[str]:
    """Next steps, most useful first: for single certain effects, then one for each class of others."""
    if diagnosis.hindrance:
        return [_DIAGNOSE_AGAIN] if not diagnosis.next_poses else [_measure(diagnosis), _DIAGNOSE_AGAIN]
    certain = [found.candidate_effect for found in diagnosis.findings if found.probability >= CERTAIN]
    doubtful = [one for one in diagnosis.model.effects if one not in certain]
    in_one_urdf = {class_of(one) for one in doubtful if one.effect.in_urdf}
    todo = [
        f"{sentence_case(named(one))}: {one.remedy}"
        for one in certain
        if not (one.effect.in_urdf and class_of(one) in in_one_urdf)
    ]
    only_imitate = unknown_instead(diagnosis.classes) is not None
    if not only_imitate:
        todo += _of_classes(diagnosis, doubtful)
    if diagnosis.wrong_input:
        todo.insert(0, "Correct the data set first, as stated above; then diagnose it again.")
    if diagnosis.pose_scatter:
        todo.append(_STAND_STILL)
    if diagnosis.verdict == "unexplained" and (_sites(diagnosis) or not diagnosis.pose_scatter):
        todo.append(_look(diagnosis))
    if diagnosis.next_poses:
        todo.append(_measure(diagnosis))
    if len(diagnosis.outliers):
        what = "measurements" if diagnosis.dataset.points.pixel is None else "images"
        poses = outlying_poses(diagnosis.dataset, diagnosis.outliers)
        odd = f"pose{'s' * (len(poses) > 1)} {shortened(poses)}" if poses else "the `gross_errors` in `diagnosis.json`"
        todo.append(f"Look at the {what} of {odd}; they are excluded here.")
    if diagnosis.model.effects:
        beware = " They only imitate the cause: use it at poses like those measured." if only_imitate else ""
        todo.append(f"The corrected model is `calibration.json`: it contains all effects found.{beware}")
    todo += _bounds(diagnosis)
    final = diagnosis.weighed.final
    off = ContradictedDistance.of(final.model, final.x)
    if off:
        todo.append(f"Measure the {off} again.")
    is_sound = diagnosis.verdict == "no_gap" and not diagnosis.wrong_input and not off
    if is_sound and diagnosis.repeatability.is_most_of(diagnosis.gap.noise_floor_m):
        turns = {name: source.value for name, source in diagnosis.repeatability.sources.items() if source.unit == "rad"}
        is_joint = turns.get("joint", 0.0) >= max(turns.values(), default=np.inf)
        finer = " Joint readings of finer resolution reduce it." if is_joint else ""
        todo.append(
            f"{_sound(diagnosis)} Most of the error is scatter of whole poses: more poses average it out, repeated"
            f" shots at one pose do not.{finer}"
        )
    elif is_sound and diagnosis.gap.after_ci95_m[1] < diagnosis.gap.noise_floor_m:
        todo.append("State less noise under `[noise]` in `dataset.toml`, then diagnose again: these data scatter less.")
    elif is_sound:
        line = ", or improve the line extraction" if diagnosis.dataset.kind == "stripe" else ""
        todo.append(f"Nothing needs repair. For higher accuracy, reduce the noise: repeat measurements{line}.")
    return todo


def _sound(diagnosis: Diagnosis) -> str:
    """Whether the arm needs repair if its poses scatter no more than usual."""
    if diagnosis.repeatability.is_stated:
        return "Nothing needs repair."
    least = millimetres(diagnosis.repeatability.at_sensor_m)
    return (
        f"Nothing needs repair unless the arm should repeat to less than {least}: state the repeatability of its data"
        " sheet as `repeatability_m` under `[noise]` in `dataset.toml`, then diagnose again."
    )


def _bounds(diagnosis: Diagnosis) -> list[str]:
    """Parameters of the sensor that ended on a bound of the data set."""
    sentences = []
    for i in np.flatnonzero(given_on_bound(diagnosis)):
        item, value = diagnosis.model.parameters.items[i], diagnosis.x[i]
        bound = "lower" if value <= item.lower else "upper"
        sentences.append(
            f"{item.name} ended on its {bound} bound, {plain(value, item.unit)}: widen its bounds in dataset.toml, or"
            " check the model."
        )
    return sentences


def _of_classes(diagnosis: Diagnosis, doubtful: Sequence[CandidateEffect]) -> list[str]:
    """Advice on each reported class with an effect that is not certain by itself."""
    of_class: dict[str, list[CandidateEffect]] = {}
    for one in doubtful:
        of_class.setdefault(class_of(one), []).append(one)
    reported = {one.name for one in diagnosis.classes}
    return [_of_class(diagnosis, name, own) for name, own in of_class.items() if name in reported]


def _of_class(diagnosis: Diagnosis, name: str, own: Sequence[CandidateEffect]) -> str:
    what = sentence_case(noun(name))
    probability = next((one.probability for one in diagnosis.classes if one.name == name), 0.0)
    if probability < CERTAIN:
        return f"{what}: not certain. Measure more poses before repairing anything."
    if all(one.effect.in_urdf for one in own):
        is_open = all(found.probability < CERTAIN for found in diagnosis.findings
                      if class_of(found.candidate_effect) == name)  # fmt: skip
        return (
            f"{what}: use `robot_corrected.urdf`. Its corrections are valid together; these poses do not show how"
            f" {'they are' if is_open else 'the rest of them is'} divided among the joints."
            f"{_unseen(diagnosis, name)}"
        )
    return f"{what}: which part is the cause is not certain. Measure more poses before repairing one."


def _unseen(diagnosis: Diagnosis, name: str) -> str:
    """Warning that a class is not corrected along undetermined directions; empty if there are none."""
    own = [found for found in diagnosis.findings if class_of(found.candidate_effect) == name]
    numbers = [number for found in own for number in found.parameters.values()]
    unseen = sum(number.std is None and not number.bound for number in numbers)
    if not unseen:
        return ""
    return (
        f" They do not determine {unseen} of {len(numbers)} parameters by themselves; the nominal values of these are"
        " kept."
    )


def _sites(diagnosis: Diagnosis) -> list[Localization]:
    """Locations of the gap other than scatter of whole poses."""
    return [part for part in diagnosis.where if part.coordinate != BY_CHANCE]


def _look(diagnosis: Diagnosis) -> str:
    where = _sites(diagnosis)
    if not where:
        return "The remaining error is at no single location. More, and more varied, poses may locate it."
    alike = {part.site: part.coordinate for part in reversed(where) if part.share >= ALIKE * where[0].share}
    sites = list(reversed(alike))
    pulled = [site for site in sites if alike[site] == FORCE]
    joints = [site for site in sites if kind_of_site(site) not in SITES and site not in pulled]
    checked = [f"gear, encoder and bearings of {joint_names(joints)}"] if joints else []
    checked += [f"cables and hoses that pull at the joints near {listed(pulled)}"] if pulled else []
    checked += list(dict.fromkeys(SITES[kind] for site in sites if (kind := kind_of_site(site)) in SITES))
    check = f"Check {listed(checked)}. The remaining error there {_form(dict.fromkeys(alike[site] for site in sites))}"
    if any(part.unknown for part in where if part.site in sites):
        return f"{check}, in a form that no effect of the library has. Write an effect of your own."
    return (
        f"{check}. The library has effects of that form, but they do not reduce the error on new poses: measure more,"
        " and more varied, poses."
    )


def _form(coordinates: Iterable[str]) -> str:
    """The coordinate that a remaining error depends on, or the effect or constant error that it looks like."""
    placed = [one for one in coordinates if one.startswith("placement of ")]
    titles = [one for one in coordinates if one in {kind.title for kind in EFFECTS}]
    depends = [f"the {one}" for one in coordinates if one not in (*placed, *titles)]
    parts = [f"depends on {listed(depends)}"] if depends else []
    parts += [f"resembles an effect: {listed(titles)}"] if titles else []
    return " and ".join([*parts, *([f"looks like a wrong {listed(placed)}"] if placed else [])])


def _measure(diagnosis: Diagnosis) -> str:
    count = len(diagnosis.next_poses)
    poses = f"the {count} pose{'s' * (count > 1)} in `next_poses` of `diagnosis.json`"
    open_ones = [found for found in diagnosis.findings if found.alternatives]
    ambiguous = min(open_ones, key=lambda found: found.probability, default=None)
    if ambiguous is None:
        return f"Measure {poses}: they are the most informative."
    other = ambiguous.alternatives[0].candidate_effect
    return f"Measure {poses}: they distinguish {named(ambiguous.candidate_effect)} from {named(other)}."
