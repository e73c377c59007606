"""A diagnosis as diagnosis.json."""

from collections.abc import Mapping, Sequence
from typing import Any

from robolaser.calibration.saved import DIAGNOSIS
from robolaser.diagnosis.cause_classes import at_least_one
from robolaser.diagnosis.gross_errors import probability
from robolaser.diagnosis.pose_scatter import CLASS, NAME, PartScatter
from robolaser.diagnosis.result import (
    CauseClass,
    DetectionLimit,
    Diagnosis,
    Estimate,
    Finding,
    Gap,
    NoiseSource,
    Validation,
    WrongInput,
)
from robolaser.model.effects.effect import CandidateEffect


def diagnosis_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """Contents of diagnosis.json, format `robolaser-diagnosis/1`."""
    gap, wrong, scatter = diagnosis.gap, diagnosis.wrong_input, diagnosis.pose_scatter
    return {
        "format": DIAGNOSIS,
        "dataset": diagnosis.dataset.name,
        "poses": dict(zip(("used", "all"), diagnosis.poses, strict=True)),
        "verdict": diagnosis.verdict,
        "sentence": diagnosis.sentence,
        "gap_mm": {
            "nominal": _mm(gap.nominal_m),
            "calibrated": _mm(gap.calibrated_m),
            "after": _mm(gap.after_m),
            "noise_floor": _mm(gap.noise_floor_m),
            "after_ci95": [_mm(end) for end in gap.after_ci95_m],
        },
        "where": [
            {"site": site.site, "coordinate": site.coordinate, "share": site.share, "p_value": site.p_value}
            for site in diagnosis.where
        ],
        "effects": ([_wrong_input(wrong)] if wrong else [])
        + [_finding(found) for found in diagnosis.findings]
        + ([_pose_scatter(scatter, gap)] if scatter else [])
        + ([_outliers(diagnosis)] if len(diagnosis.outliers) else []),
        "kinds": ([_kind(wrong.name, [wrong.where], wrong.probability, wrong.gap_before_m)] if wrong else [])
        + [_kind(one.effect, one.where, one.probability, one.gap_without_m) for one in diagnosis.kinds]
        + ([_kind(NAME, [scatter.where], scatter.as_cause)] if scatter else []),
        "classes": _classes(diagnosis),
        "gross_errors": diagnosis.outliers.tolist(),
        "not_testable": [{"effect": name, "reason": reason} for name, reason in diagnosis.not_testable.items()],
        "next_poses": [dict(pose) for pose in diagnosis.next_poses],
        "detection_limits": [_limit(one) for one in diagnosis.limits],
        "noise": {name: _noise(source) for name, source in diagnosis.noise.items()},
        "repeatability": {name: _noise(source) for name, source in diagnosis.repeatability.sources.items()}
        | {"mm_at_sensor": _mm(diagnosis.repeatability.at_sensor_m)},
        "noise_remarks": list(diagnosis.noise_remarks),
        "validation": [_validation(one) for one in diagnosis.validation],
        "seconds": diagnosis.seconds,
    }


def _noise(source: NoiseSource) -> dict[str, Any]:
    return {"value": source.value, "unit": source.unit, "origin": source.origin}


def _mm(metres: float | None) -> float | None:
    return None if metres is None else 1e3 * metres


def _named(candidate_effect: CandidateEffect) -> dict[str, str]:
    return {"effect": candidate_effect.effect.name, "where": candidate_effect.where}


def _pair(candidate_effect: CandidateEffect) -> list[str]:
    return [candidate_effect.effect.name, candidate_effect.where]


def _limit(one: DetectionLimit) -> dict[str, Any]:
    return {
        **_named(one.candidate_effect),
        "number": one.parameter,
        "size": one.size,
        "unit": one.unit,
        "identifiable": one.identifiable,
        "rival": None if one.rival is None else _pair(one.rival),
        "at_tool_mm": _mm(one.at_tool_m),
        "is_imitated": one.is_imitated,
    }


def _kind(effect: str, where: Sequence[str], probability: float, without_m: float | None = None) -> dict[str, Any]:
    return {"effect": effect, "where": list(where), "probability": probability, "gap_mm_without": _mm(without_m)}


def _finding(found: Finding) -> dict[str, Any]:
    gaps = found.gap_before_m, found.gap_after_m, found.gap_without_m
    rivals = [_pair(alternative.candidate_effect) for alternative in found.alternatives]
    return _effect(_named(found.candidate_effect), found.probability, _numbers(found.parameters), gaps, rivals)


def _effect(
    named: dict[str, str],
    probability: float,
    parameters: dict[str, Any],
    gaps_m: tuple[float, float, float],
    rivals: Sequence[list[str]] = (),
) -> dict[str, Any]:
    """An effect with the gap before it, after it and without it."""
    before, after, without = map(_mm, gaps_m)
    return {
        **named,
        "probability": probability,
        "parameters": parameters,
        "gap_mm_before": before,
        "gap_mm_after": after,
        "gap_mm_without": without,
        "indistinguishable_from": list(rivals),
    }


def _numbers(parameters: Mapping[str, Estimate]) -> dict[str, Any]:
    return {
        name: {"value": number.value, "std": number.std, "unit": number.unit}
        | ({"on_bound": number.bound} if number.bound else {})
        for name, number in parameters.items()
    }


def _validation(one: Validation) -> dict[str, Any]:
    return {
        "dataset": one.dataset,
        "nominal_mm": _mm(one.nominal_m),
        "calibrated_mm": _mm(one.calibrated_m),
        "after_mm": _mm(one.after_m),
        "noise_floor_mm": _mm(one.noise_floor_m),
        "rows": one.rows,
        "remarks": list(one.remarks),
    }


def _class(one: CauseClass, scatter: PartScatter | None) -> dict[str, Any]:
    members = [{**_named(member), "probability": probability} for member, probability in one.members]
    if scatter and one.name == CLASS:
        members = [{"effect": NAME, "where": scatter.where, "probability": scatter.as_cause}]
    return {
        "class": one.name,
        "probability": one.probability,
        "gap_mm_without": _mm(one.gap_without_m),
        "gap_mm_with": _mm(one.gap_with_m),
        "members": members,
        "credible_sets": [[_pair(member) for member in candidates] for candidates in one.credible_sets],
        **({"site": one.site} if one.site else {}),
    }


def _pose_scatter(scatter: PartScatter, gap: Gap) -> dict[str, Any]:
    """Scatter of whole poses as a finding: it is chance and leaves the gap unchanged."""
    sizes = {name: {"value": size.value, "std": size.std, "unit": size.unit} for name, size in scatter.sizes.items()}
    return _effect({"effect": NAME, "where": scatter.where}, scatter.as_cause, sizes, (gap.after_m,) * 3)


def _wrong_input(found: WrongInput) -> dict[str, Any]:
    gaps = found.gap_before_m, found.gap_after_m, found.gap_before_m
    named = {"effect": found.name, "where": found.where}
    return _effect(named, found.probability, _numbers(found.parameters), gaps, [*map(_pair, found.alternatives)])


def _classes(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Each class once, first that of a fault of the data set together with the effects of this class."""
    found = diagnosis.wrong_input
    classes = [_class(one, diagnosis.pose_scatter) for one in diagnosis.classes]
    if found is None:
        return classes
    own = [one for one in classes if one["class"] == found.cause]
    member = {"effect": found.name, "where": found.where, "probability": found.probability}
    members = [member, *(each for one in own for each in one["members"])]
    gaps_mm = [1e3 * found.gap_before_m, *(one["gap_mm_without"] or 0.0 for one in own)]
    credible_set = [[found.name, found.where], *map(_pair, found.alternatives)]
    whole = {
        "class": found.cause,
        "probability": at_least_one([found.probability, *(one["probability"] for one in own)]),
        "gap_mm_without": max(gaps_mm),
        "gap_mm_with": _mm(diagnosis.gap.after_m),
        "members": sorted(members, key=lambda one: -one["probability"]),
        "credible_sets": [credible_set, *(each for one in own for each in one["credible_sets"])],
    }
    return [whole, *(one for one in classes if one not in own)]


def _outliers(diagnosis: Diagnosis) -> dict[str, Any]:
    """Gross errors as a finding: they are excluded, not modelled, and leave the gap unchanged."""
    share = len(diagnosis.outliers) / max(1, len(diagnosis.dataset.points))
    return _effect(
        {"effect": "outliers", "where": "image"},
        probability(diagnosis.dataset, diagnosis.outliers, diagnosis.verdict),
        {"share": {"value": share, "std": None, "unit": ""}},
        (diagnosis.gap.after_m,) * 3,
    )
