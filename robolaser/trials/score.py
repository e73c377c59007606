"""The score of many diagnoses: shares with intervals, reliability of the stated probabilities."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import pairwise
from typing import Any

import numpy as np

from robolaser.benchmark.statistics.intervals import wilson
from robolaser.trials.outcome import Outcome

FORMAT = "robolaser-score/1"
GROUPS = ("one", "confusable", "none", "outliers", "several", "unknown")  # of worlds, by what counts as right
COUNTED = ("stated", "stated_classes", "covered")  # over all worlds, and not listed for each
BINS = (0.0, 0.5, 0.8, 0.9, 0.95, 0.99, 1.0)  # edges of the reliability curve


def share(hits: Sequence[bool]) -> dict[str, Any]:
    """How many of how many, and Wilson's 95 % interval of the share; null for none of none."""
    right = int(sum(hits))
    found = wilson(right, len(hits))
    interval = None if found.value is None else [found.lower, found.upper]
    return {"right": right, "of": len(hits), "share": found.value, "ci95": interval}


def compile_score(outcomes: Mapping[str, Outcome]) -> dict[str, Any]:
    """The score of a trial, as score.json holds it, of the outcomes by data set."""
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
    """How often class, verdict, place and intervals are right, and how often what is stated as sure is wrong."""
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
