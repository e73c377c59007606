"""One diagnosis compared with the truth: which group its data set is in, and whether the diagnosis is right."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import Any, final

from robolaser.trials.detectability import DETECTABLE
from robolaser.trials.synthetic.fault_models import OUTLIERS, UNMODELLED

FLOOR = 1.1  # times the noise floor: a gap that no reader would call one
SURE = 0.9  # a probability by which people act
NORMAL_95 = 1.959964
SIZED = ("encoder_scale", "joint_offset", "laser_roll", "target_scale")
"""Effects whose principal number means the same in the truth's form and in the library's, save for its sign."""

LocatedEffect = tuple[str, str]


@final
@dataclass(frozen=True)
class Outcome:
    """What became of one world.

    Attributes:
        group: `none`, `outliers`, `one` (identifiable), `confusable`, `several`, `unknown`, or `faint`: with a known
            effect too small to be asked for.
        right: Whether the diagnosis is what one may ask for in this group.
        truth: Effects and places, outliers left out.
        named: Those of the diagnosis, likewise, first things first.
        verdict: Of the diagnosis.
        stated: For each effect named, its probability and whether it is in the world.
        sure_and_wrong: Unexplained, and yet some wrong cause is all but certain.
        site: Whether `where` begins with a true site; None where there is nothing to find.
        left: Gap after the diagnosis over the noise floor; None where it says nothing.
        closed: Share of the squared gap above the noise that the diagnosis closed; None where there was hardly one.
        covered: For each effect with a comparable number: whether its 95 % interval holds the truth.
    """

    group: str
    right: bool
    truth: tuple[LocatedEffect, ...]
    named: tuple[LocatedEffect, ...]
    verdict: str
    stated: tuple[tuple[float, bool], ...]
    sure_and_wrong: bool
    site: bool | None
    left: float | None
    closed: float | None
    covered: tuple[bool, ...]


def outcome(truth: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> Outcome:
    """Hold a diagnosis (as in diagnosis.json) against the sealed truth of its data set.

    Effects of the truth that were taken out of the library beforehand (`withheld`) count as unknown.
    """
    each = [item for item in truth["each"] if item["effect"] != OUTLIERS]
    true = tuple((item["effect"], item["where"]) for item in each)
    findings = [item for item in diagnosis["effects"] if item["effect"] != OUTLIERS]
    named = tuple((item["effect"], item["where"]) for item in findings)
    classes = [
        {place, *map(tuple, item["indistinguishable_from"])} for place, item in zip(named, findings, strict=True)
    ]
    group = _group(truth, each)
    gap = diagnosis["gap_mm"]
    left = _ratio(gap["after"], gap["noise_floor"])
    verdict = diagnosis["verdict"]
    stated = tuple((float(item["probability"]), place in true) for place, item in zip(named, findings, strict=True))
    sure_and_wrong = verdict == "unexplained" and any(p >= SURE and not held for p, held in stated)
    sites = {site for item in each for site in item["sites"]}
    where = diagnosis["where"]
    return Outcome(
        group=group,
        right={
            "none": verdict == "no_gap" and not named,
            "outliers": not named,
            "one": named == true,
            "confusable": any(true[0] in alike for alike in classes[:1]) if true else False,
            "several": len(named) == len(true) and _matched(each, named, classes),
            "unknown": (verdict == "unexplained" or (left is not None and left <= FLOOR)) and not sure_and_wrong,
            "faint": all(place in true for place in named),
        }[group],
        truth=true,
        named=named,
        verdict=verdict,
        stated=stated,
        sure_and_wrong=sure_and_wrong,
        site=bool(where) and where[0]["site"] in sites if sites and group != "faint" else None,
        left=left,
        closed=_closed(gap),
        covered=tuple(_covered(each, findings)),
    )


def _group(truth: Mapping[str, Any], each: Sequence[Mapping[str, Any]]) -> str:
    if any(item["effect"] in UNMODELLED or item.get("withheld") for item in each):
        return "unknown"
    if not each:
        return "outliers" if truth["each"] else "none"
    if any(item["misfit"] <= DETECTABLE for item in each):
        return "faint"
    if len(each) > 1:
        return "several"
    return "confusable" if each[0]["rivals"] else "one"


def _matched(each: Sequence[Mapping[str, Any]], named: Sequence[LocatedEffect], classes: Sequence[set[Any]]) -> bool:
    """Whether each true effect can be paired with one that was named: itself, or one of its class."""

    def alike(item: Mapping[str, Any], i: int) -> bool:
        return (item["effect"], item["where"]) in classes[i] or list(named[i]) in item["rivals"]

    return any(
        all(alike(item, i) for item, i in zip(each, order, strict=True)) for order in permutations(range(len(named)))
    )


def _ratio(above: float | None, below: float | None) -> float | None:
    return None if above is None or not below else above / below


def _closed(gap: Mapping[str, Any]) -> float | None:
    numbers = [gap[name] for name in ("calibrated", "after", "noise_floor")]
    if any(number is None for number in numbers) or numbers[0] <= FLOOR * numbers[2]:
        return None
    calibrated, after, floor = (number**2 for number in numbers)
    return float(1.0 - max(0.0, after - floor) / (calibrated - floor))


def _covered(each: Sequence[Mapping[str, Any]], findings: Sequence[Mapping[str, Any]]) -> list[bool]:
    covered = []
    for item in each:
        for finding in findings:
            if item["effect"] in SIZED and (finding["effect"], finding["where"]) == (item["effect"], item["where"]):
                number = next(iter(finding["parameters"].values()))
                if number["std"] is not None:
                    covered.append(abs(abs(number["value"]) - abs(item["size"])) <= NORMAL_95 * number["std"])
    return covered
