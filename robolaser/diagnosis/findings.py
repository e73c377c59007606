"""The account of a diagnosis: the gap step by step, each effect with its numbers and rivals, what was not tested."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import chi2

from robolaser.arrays import Array
from robolaser.calibration.result import rms
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.averaging import of_rows, size
from robolaser.diagnosis.held_out_gap import Unseen, interval
from robolaser.diagnosis.localization import Localization, where
from robolaser.diagnosis.penalized_fit import Fitted
from robolaser.diagnosis.probabilities import Stand, rival
from robolaser.diagnosis.result import Alternative, DetectionLimit, Estimate, Finding, Gap
from robolaser.diagnosis.selection import Search
from robolaser.diagnosis.verdict import FEWEST_POSES
from robolaser.model.effects.effect import CandidateEffect, Effect

MOST_RIVALS = 6
"""Rivals that are told of each effect, the nearest first."""


def findings_of(
    search: Search, start: Fitted, final: Fitted, standing: list[Stand], unseen: Unseen, seed: int
) -> tuple[Gap, tuple[Finding, ...], Array, Array]:
    """The held-out gap step by step, the effects added in the order in which they help most."""
    before, after = unseen.errors(start), unseen.errors(final)
    order, state = [], start
    by_suspect = {signature.candidate_effect: signature for signature in search.seen(final)}
    gaps = [rms(before)]
    remaining = list(final.effects)
    while remaining:
        options = [search.fit(state, [by_suspect[candidate_effect]]) for candidate_effect in remaining]
        best = int(np.argmin([option.misfit for option in options]))
        order.append(remaining.pop(best))
        state = options[best]
        gaps.append(unseen.gap(state) if remaining else rms(after))
    stand_of = {stand.candidate_effect: stand for stand in standing}
    findings = tuple(
        Finding(
            candidate_effect=candidate_effect,
            probability=stand_of[candidate_effect].probability,
            parameters=_numbers(final, candidate_effect),
            gap_before_m=gaps[i],
            gap_after_m=gaps[i + 1],
            gap_without_m=unseen.gap(stand_of[candidate_effect].without),
            alternatives=_rivals(stand_of[candidate_effect], final, unseen),
        )
        for i, candidate_effect in enumerate(order)
    )
    given = any(item.given for item in start.problem.sensor.items)
    nominal = start.problem.plain(start.problem.parameters.nominal[None])[0] if given else start.plain
    floor = size(of_rows(final.problem.noise))
    gap = Gap(rms(nominal), gaps[0], rms(after), floor, interval(after, start.problem.model.dataset.points.pose, seed))
    return gap, findings, before, after


def _rivals(stand: Stand, final: Fitted, unseen: Unseen) -> tuple[Alternative, ...]:
    return tuple(
        Alternative(candidate_effect, _numbers(fit, candidate_effect), unseen.gap(fit))
        for candidate_effect, fit in zip(rival(stand, final)[:MOST_RIVALS], stand.alternatives, strict=False)
    )


def _numbers(final: Fitted, candidate_effect: CandidateEffect) -> Mapping[str, Estimate]:
    names = final.problem.parameters.names
    found = {}
    for item in candidate_effect.parameters.items:
        column = names.index(item.name)
        variance = float(final.covariance[column, column])
        found[item.name.rsplit(".", 1)[1]] = Estimate(
            float(final.x[column]), float(np.sqrt(max(variance, 0.0))), item.unit
        )
    return found


def places_of(start: Fitted, final: Fitted, lost: Mapping[CandidateEffect, float]) -> list[Localization]:
    """Where the gap lay, by what each effect explains of it."""
    freedoms = len(start.r) - len(start.x)
    excess = max(start.misfit - freedoms, 1e-9)
    closed = float(np.clip((start.misfit - final.misfit) / excess, 0.0, 1.0))
    total = max(sum(lost.values()), 1e-9)
    seen = {lies.site: lies for lies in reversed(where(start))}
    found: dict[str, Localization] = {}
    for candidate_effect, gain in lost.items():
        share = closed * gain / total + (
            found[candidate_effect.where].share if candidate_effect.where in found else 0.0
        )
        coordinate = (
            seen[candidate_effect.where].coordinate if candidate_effect.where in seen else candidate_effect.kind.title
        )
        p_value = float(chi2.sf(gain, len(candidate_effect.kind.declared()) + len(candidate_effect.kind.shapes())))
        found[candidate_effect.where] = Localization(candidate_effect.where, coordinate, share, gain, p_value)
    return sorted(found.values(), key=lambda lies: -lies.share)


def not_testable(
    kinds: Sequence[type[Effect]], dataset: Dataset, limit: Sequence[DetectionLimit], *, enough: bool
) -> dict[str, str]:
    """Why an effect could not be tested, by its name."""
    if not enough:
        return {kind.name: f"fewer than {FEWEST_POSES} poses show something" for kind in kinds}
    reasons = {kind.name: reason for kind in kinds if (reason := kind.missing(dataset))}
    unseen: dict[str, list[str]] = {}
    for one in limit:
        if one.size is None:
            unseen.setdefault(one.candidate_effect.kind.name, []).append(one.candidate_effect.where)
    for name, places in unseen.items():
        reasons.setdefault(name, f"at {', '.join(places)} these poses cannot tell it from the ordinary parameters")
    return reasons
