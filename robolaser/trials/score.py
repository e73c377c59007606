"""Diagnoses compared with the truth, one by one, and the score of many: shares with intervals, and reliability."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise, permutations
from typing import Any, final

import numpy as np

from robolaser.benchmark.statistics.intervals import wilson
from robolaser.model.effects import EFFECTS
from robolaser.trials.detectability import DETECTABLE
from robolaser.trials.synthetic.fault_models import OUTLIERS

FORMAT = "robolaser-score/1"
GROUPS = ("one", "confusable", "none", "outliers", "several", "unknown")  # of worlds, by the criterion of success
COUNTED = ("stated", "stated_classes", "covered")  # over all worlds, and not listed for each
BINS = (0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 1.0)  # edges of the reliability curve
FLOOR = 1.1  # times the noise floor: a negligible gap
SURE = 0.9  # probability that counts as certain
LIKELY = 0.5
NORMAL_95 = 1.959964
CHANCE = (OUTLIERS, "pose_scatter")  # named, but not modelled by effects
UNKNOWN = "unknown"  # the class of causes that no effect of the library describes

_CLASS_OF = {effect.name: effect.cause or effect.name for effect in EFFECTS}
_AMPLITUDES = {effect.name: {each.name for each in effect.amplitudes()} for effect in EFFECTS}

LocatedEffect = tuple[str, str]


@final
@dataclass(frozen=True)
class Outcome:
    """The result for one world."""

    kind: str  # of the world
    # `none`, `outliers`, `one` (identifiable), `confusable`, `several`, `unknown`, or `faint`: with a known effect
    # too small to be required
    group: str
    right: bool  # whether the diagnosis meets the criterion of this group
    # whether every true class is likely and no wrong one is certain; None where nothing is required, or where the
    # diagnosis states no classes
    class_right: bool | None
    verdict_right: bool | None  # whether the verdict is right; None where nothing is required
    sure_and_wrong: bool  # whether a wrong name counts as certain
    site_first: bool | None  # whether `where` begins with a true site; None where none is required
    truth: tuple[LocatedEffect, ...]  # effects and locations without outliers
    named: tuple[LocatedEffect, ...]  # the same of the diagnosis in order, without true small errors
    verdict: str  # of the diagnosis
    stated: tuple[tuple[float, bool], ...]  # for each effect named, its probability and whether it is in the world
    stated_classes: tuple[tuple[float, bool], ...]  # the same of classes
    covered: tuple[bool, ...]  # for each number with a 95 % interval, whether that holds the truth


def outcome(truth: Mapping[str, Any], diagnosis: Mapping[str, Any]) -> Outcome:
    """Compare a diagnosis (as in diagnosis.json) with the sealed truth of its data set.

    Effects of the truth that were removed from the library (`withheld`) count as unknown.
    """
    each = [item for item in truth["each"] if item["effect"] != OUTLIERS]
    true = tuple((item["effect"], item["where"]) for item in each)
    small = {tuple(place) for place in truth.get("background", [])}
    as_good = {*true, *small, *(tuple(place) for item in each for place in item["also_right"])}
    causes = [((one["effect"], one["where"]), one) for one in diagnosis["effects"] if one["effect"] not in CHANCE]
    stated = tuple((float(one["probability"]), place in as_good) for place, one in causes)
    findings = {place: one for place, one in causes if place not in small - set(true)}
    named = tuple(findings)
    alike = [{place, *map(tuple, one["indistinguishable_from"])} for place, one in findings.items()]
    group = _group(truth, each)
    gap = diagnosis["gap_mm"]
    after, floor = gap["after"], gap["noise_floor"]
    at_floor = bool(floor) and after is not None and after / floor <= FLOOR
    verdict = diagnosis["verdict"]
    sure_and_wrong = any(p >= SURE and not held for p, held in stated)
    sites = {site for item in each for site in item["sites"]}
    where = diagnosis["where"]
    classes = [  # for each effect, one must be likely: its own or a rival's
        {*item["classes"], *(_CLASS_OF[name] for name, _ in item["rivals"]), *([UNKNOWN] if _is_unknown(item) else [])}
        for item in each
    ]
    left_small = bool(small) and verdict == "unexplained"  # `where` and `unknown` then describe small errors
    right_classes = {_CLASS_OF[effect] for effect, _ in small}.union(*classes)
    probabilities = {
        item["class"]: float(item["probability"])
        for item in diagnosis.get("classes", [])
        if not (left_small and item["class"] == UNKNOWN)
    }
    return Outcome(
        kind=truth.get("kind", ""),
        group=group,
        right={
            "none": not named and (verdict == "no_gap" or bool(small)),
            "outliers": not named,
            "one": named == true,
            "confusable": any(true[0] in some for some in alike[:1]) if true else False,
            "several": len(named) == len(true) and _matched(each, named, alike),
            "unknown": (verdict == "unexplained" or at_floor) and not sure_and_wrong,
            "faint": all(place in true for place in named),
        }[group],
        class_right=(
            None
            if group == "faint" or "classes" not in diagnosis
            else all(any(probabilities.get(name, 0.0) >= LIKELY for name in some) for some in classes)
            and all(p < SURE for name, p in probabilities.items() if name not in right_classes)
        ),
        verdict_right=_verdict_right(group, verdict, at_floor=at_floor, small=bool(small)),
        sure_and_wrong=sure_and_wrong,
        site_first=bool(where) and where[0]["site"] in sites if sites and group != "faint" and not left_small else None,
        truth=true,
        named=named,
        verdict=verdict,
        stated=stated,
        stated_classes=tuple((p, name in right_classes) for name, p in probabilities.items()),
        covered=tuple(_covered(each, findings)),
    )


def _is_unknown(item: Mapping[str, Any]) -> bool:
    return item["effect"] not in _CLASS_OF or bool(item.get("withheld"))


def _verdict_right(group: str, verdict: str, *, at_floor: bool, small: bool) -> bool | None:
    """Whether the verdict is right; small errors may remain or be explained, and may be the only ones."""
    if group == "faint" or (small and group == "none"):
        return None
    if small:
        return verdict != "no_gap"
    if group == "unknown":
        return verdict == "unexplained" or (verdict == "explained" and at_floor)
    return verdict == ("no_gap" if group in ("none", "outliers") else "explained")


def _group(truth: Mapping[str, Any], each: Sequence[Mapping[str, Any]]) -> str:
    if any(_is_unknown(item) for item in each):
        return "unknown"
    if not each:
        return "outliers" if truth["each"] else "none"
    if any(item["misfit"] <= DETECTABLE for item in each):
        return "faint"
    if len(each) > 1:
        return "several"
    return "confusable" if each[0]["rivals"] else "one"


def _matched(each: Sequence[Mapping[str, Any]], named: Sequence[LocatedEffect], alike: Sequence[set[Any]]) -> bool:
    """Whether each true effect can be paired with a named one: itself, or one of its class."""

    def is_same(item: Mapping[str, Any], i: int) -> bool:
        return (item["effect"], item["where"]) in alike[i] or list(named[i]) in item["rivals"]

    return any(all(map(is_same, each, order)) for order in permutations(range(len(named))))


def _covered(each: Sequence[Mapping[str, Any]], findings: Mapping[LocatedEffect, Mapping[str, Any]]) -> list[bool]:
    """Whether intervals hold the true amplitudes of effects that were found; undetermined ones have no interval."""
    covered = []
    for item in each:
        found = findings.get((item["effect"], item["where"]), {"parameters": {}})["parameters"]
        for name, value in item["values"].items():
            number = found.get(name)
            if number is not None and number["std"] is not None and name in _AMPLITUDES[item["effect"]]:
                covered.append(abs(value - number["value"]) <= NORMAL_95 * number["std"])
    return covered


def share(hits: Sequence[bool]) -> dict[str, Any]:
    """Counts, share and Wilson's 95 % interval of it; null for none of none."""
    right = int(sum(hits))
    found = wilson(right, len(hits))
    interval = None if found.value is None else [found.lower, found.upper]
    return {"right": right, "of": len(hits), "share": found.value, "ci95": interval}


def compile_score(outcomes: Mapping[str, Outcome]) -> dict[str, Any]:
    """The score of a trial for score.json, from the outcomes by data set."""
    every = list(outcomes.values())
    by_kind = {kind: [o for o in every if o.kind == kind] for kind in sorted({o.kind for o in every})}
    return {
        "format": FORMAT,
        "worlds": len(every),
        "groups": {group: share([o.right for o in every if o.group == group]) for group in GROUPS},
        "kinds": {
            kind: {"worlds": len(alike), "by_name": share([o.right for o in alike]), **_shares(alike)}
            for kind, alike in by_kind.items()
        },
        **_shares(every),
        "reliability": _reliability([pair for o in every for pair in o.stated]),
        "reliability_of_classes": _reliability([pair for o in every for pair in o.stated_classes]),
        "each": {
            name: {key: value for key, value in asdict(o).items() if key not in COUNTED} for name, o in outcomes.items()
        },
    }


def _shares(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Shares of right classes, verdicts, locations and intervals, and of certain but wrong statements."""
    return {
        "by_class": share([o.class_right for o in outcomes if o.class_right is not None]),
        "verdict": share([o.verdict_right for o in outcomes if o.verdict_right is not None]),
        "site_first": share([o.site_first for o in outcomes if o.site_first is not None]),
        "sure_and_wrong": share([o.sure_and_wrong for o in outcomes]),
        "coverage_95": share([held for o in outcomes for held in o.covered]),
    }


def _reliability(stated: Sequence[tuple[float, bool]]) -> list[dict[str, Any]]:
    curve = []
    for low, high in pairwise(BINS):
        inside = [pair for pair in stated if low <= pair[0] < high or (pair[0] == high == BINS[-1])]
        mean = float(np.mean([p for p, _ in inside])) if inside else None
        curve.append({"from": low, "to": high, "stated": mean, **share([held for _, held in inside])})
    return curve
