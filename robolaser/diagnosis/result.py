"""What a diagnosis says: the verdict, the gap step by step, the places, the effects, and what to do next."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.repeatability import NoiseSource, Repeatability
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model

FORMAT = "robolaser-diagnosis/1"


@final
@dataclass(frozen=True)
class Estimate:
    """A parameter of an effect.

    Attributes:
        value: In its unit.
        std: One standard deviation; None where the data do not fix it, or a bound does.
        unit: SI.
        bound: `lower` or `upper` where the value ended on that bound, else empty.
    """

    value: float
    std: float | None
    unit: str
    bound: str = ""


@final
@dataclass(frozen=True)
class Alternative:
    """An effect that these poses cannot tell from one that was found.

    Attributes:
        candidate_effect: Which, and where.
        parameters: Its parameters in the other's place, by name.
        gap_m: Held-out gap with it in the other's place.
    """

    candidate_effect: CandidateEffect
    parameters: Mapping[str, Estimate]
    gap_m: float


@final
@dataclass(frozen=True)
class Finding:
    """An effect that was found.

    Attributes:
        candidate_effect: Which, and where.
        probability: Of it, at this place, against every other candidate, none, and something unknown.
        parameters: By name.
        gap_before_m: Held-out gap with the effects found before it in the model.
        gap_after_m: With this one too.
        gap_without_m: With all but this one.
        alternatives: Effects that these poses cannot tell from it, the nearest first.
    """

    candidate_effect: CandidateEffect
    probability: float
    parameters: Mapping[str, Estimate]
    gap_before_m: float
    gap_after_m: float
    gap_without_m: float
    alternatives: tuple[Alternative, ...]


@final
@dataclass(frozen=True)
class CauseClass:
    """A class of causes.

    Attributes:
        name: Of the class.
        probability: That at least one of its members is at work.
        gap_without_m: Held-out gap of the final model without all of its members [m]; None where it has none of them.
        gap_with_m: The same of the final model [m].
        members: Its effects that may be at work, each with its probability, the most probable first.
        credible_sets: For each of its effects that were found, the fewest candidates of any class of which one is at
            work with 95 %.
        site: Of an unknown cause.
    """

    name: str
    probability: float
    gap_without_m: float | None
    gap_with_m: float
    members: tuple[tuple[CandidateEffect, float], ...] = ()
    credible_sets: tuple[tuple[CandidateEffect, ...], ...] = ()
    site: str = ""


@final
@dataclass(frozen=True)
class Gap:
    """Root-mean-square 3-D error on held-out poses, repeats averaged, gross errors left out [m]."""

    nominal_m: float
    calibrated_m: float
    after_m: float
    noise_floor_m: float
    after_ci95_m: tuple[float, float]


@final
@dataclass(frozen=True)
class DetectionLimit:
    """The smallest size of an effect's principal number that these data would have shown nine times in ten.

    Attributes:
        candidate_effect: Which, and where.
        parameter: Name of its principal parameter.
        size: In its unit; None where no plausible size shows.
        unit: SI.
        identifiable: The smallest size at which it is told from its nearest rival; None where no plausible size is.
        rival: The candidate, of no higher complexity penalty, that looks most like it; None where none does.
        at_tool_m: By how much an effect of just the detectable size moves what is measured, root mean square over these
            data, nothing refitted [m].
    """

    candidate_effect: CandidateEffect
    parameter: str
    size: float | None
    unit: str
    identifiable: float | None = None
    rival: CandidateEffect | None = None
    at_tool_m: float | None = None


@final
@dataclass(frozen=True)
class ParetoPoint:
    """A set of effects on the front of gap against complexity: none with fewer has a smaller held-out gap."""

    effects: tuple[CandidateEffect, ...]
    gap_m: float


@final
@dataclass(frozen=True)
class Validation:
    """Other data of the same arm, predicted with what was found; only where things stand was fitted anew.

    Errors are root-mean-square 3-D errors on poses held out from that fit, gross errors left out [m].

    Attributes:
        dataset: Name of the other data set.
        nominal_m: With the sim's arm and sensor.
        calibrated_m: With the ordinary parameters that were found, without effects.
        after_m: With all effects found, as they carry over.
        noise_floor_m: What noise alone would give.
        is_better: Whether the effects clearly lower the error, poses being drawn by chance.
        rows: Rows compared, repeats averaged.
        remarks: What did not carry over as it was found, and rows left out.
    """

    dataset: str
    nominal_m: float
    calibrated_m: float
    after_m: float
    noise_floor_m: float
    is_better: bool
    rows: int
    remarks: tuple[str, ...]


@final
@dataclass(frozen=True)
class Diagnosis:
    """The answer.

    Attributes:
        dataset: What was diagnosed.
        verdict: `no_gap`, `explained` or `unexplained`.
        sentence: The verdict for a person.
        gap: How far the gap shrinks.
        where: Places of the gap; for `unexplained`, of what is left.
        findings: Effects found, that without which the gap would be largest first; of those in the model, the few that
            are too improbable by themselves are left out.
        classes: Classes of causes that may be at work, most important first.
        outliers: Rows of points.csv (from 0) that are gross errors.
        not_testable: Why an effect could not be tested, by its name.
        next_poses: Joint values by name, that would tell the leading rivals apart.
        limits: Detection limits of effects that were not found.
        front: Gap against complexity.
        model: The final model, on averaged rows.
        x: Its parameters, in the order of `model.parameters`.
        std: One standard deviation of each; NaN for what is held.
        calibrated_x: The sensor's parameters without effects in the model, in the same order.
        observed: Averaged rows without gross errors.
        before_m: Held-out errors of those rows in the calibrated model, (m, 3).
        after_m: The same with all effects, (m, 3).
        noise: Sources of noise, by name.
        repeatability: How much whole poses scatter.
        noise_remarks: Sentences on what is not as it should be with the noise.
        seconds: Time taken.
        validation: Other data of the same arm, predicted with what was found.
    """

    dataset: Dataset
    verdict: str
    sentence: str
    gap: Gap
    where: tuple[Localization, ...]
    findings: tuple[Finding, ...]
    classes: tuple[CauseClass, ...]
    outliers: Ints
    not_testable: Mapping[str, str]
    next_poses: tuple[Mapping[str, float], ...]
    limits: tuple[DetectionLimit, ...]
    front: tuple[ParetoPoint, ...]
    model: Model
    x: Array
    std: Array
    calibrated_x: Array
    observed: Dataset
    before_m: Array
    after_m: Array
    noise: Mapping[str, NoiseSource]
    repeatability: Repeatability
    noise_remarks: tuple[str, ...]
    seconds: float
    validation: tuple[Validation, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """What diagnosis.json holds."""
        gap = self.gap
        return {
            "format": FORMAT,
            "dataset": self.dataset.name,
            "verdict": self.verdict,
            "sentence": self.sentence,
            "gap_mm": {
                "nominal": _mm(gap.nominal_m),
                "calibrated": _mm(gap.calibrated_m),
                "after": _mm(gap.after_m),
                "noise_floor": _mm(gap.noise_floor_m),
                "after_ci95": [_mm(end) for end in gap.after_ci95_m],
            },
            "where": [
                {"site": lies.site, "coordinate": lies.coordinate, "share": lies.share, "p_value": lies.p_value}
                for lies in self.where
            ],
            "effects": [_finding(found) for found in self.findings] + ([_outliers(self)] if len(self.outliers) else []),
            "classes": [_class(one) for one in self.classes],
            "gross_errors": self.outliers.tolist(),
            "not_testable": [{"effect": name, "reason": reason} for name, reason in self.not_testable.items()],
            "next_poses": [dict(pose) for pose in self.next_poses],
            "detection_limits": [_limit(one) for one in self.limits],
            "front": [
                {
                    "effects": [_pair(candidate_effect) for candidate_effect in choice.effects],
                    "gap_mm": _mm(choice.gap_m),
                }
                for choice in self.front
            ],
            "noise": {name: _noise(source) for name, source in self.noise.items()},
            "repeatability": {name: _noise(source) for name, source in self.repeatability.sources.items()}
            | {"mm_at_sensor": _mm(self.repeatability.at_sensor_m)},
            "noise_remarks": list(self.noise_remarks),
            "validation": [_validation(one) for one in self.validation],
            "seconds": self.seconds,
        }


def _noise(source: NoiseSource) -> dict[str, Any]:
    return {"value": source.value, "unit": source.unit, "origin": source.origin}


def _mm(metres: float) -> float:
    return 1e3 * metres


def _place(candidate_effect: CandidateEffect) -> dict[str, str]:
    return {"effect": candidate_effect.effect.name, "where": candidate_effect.where}


def _pair(candidate_effect: CandidateEffect) -> list[str]:
    return [candidate_effect.effect.name, candidate_effect.where]


def _limit(one: DetectionLimit) -> dict[str, Any]:
    return {
        **_place(one.candidate_effect),
        "number": one.parameter,
        "size": one.size,
        "unit": one.unit,
        "identifiable": one.identifiable,
        "rival": None if one.rival is None else _pair(one.rival),
        "at_tool_mm": None if one.at_tool_m is None else _mm(one.at_tool_m),
    }


def _finding(found: Finding) -> dict[str, Any]:
    return {
        **_place(found.candidate_effect),
        "probability": found.probability,
        "parameters": {
            name: {"value": number.value, "std": number.std, "unit": number.unit}
            | ({"on_bound": number.bound} if number.bound else {})
            for name, number in found.parameters.items()
        },
        "gap_mm_before": _mm(found.gap_before_m),
        "gap_mm_after": _mm(found.gap_after_m),
        "gap_mm_without": _mm(found.gap_without_m),
        "indistinguishable_from": [_pair(alternative.candidate_effect) for alternative in found.alternatives],
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


def _class(one: CauseClass) -> dict[str, Any]:
    return {
        "class": one.name,
        "probability": one.probability,
        "gap_mm_without": None if one.gap_without_m is None else _mm(one.gap_without_m),
        "gap_mm_with": _mm(one.gap_with_m),
        "members": [{**_place(member), "probability": probability} for member, probability in one.members],
        "credible_sets": [[_pair(member) for member in some] for some in one.credible_sets],
        **({"site": one.site} if one.site else {}),
    }


def _outliers(diagnosis: Diagnosis) -> dict[str, Any]:
    """Gross errors as a finding: survived, not modelled, so they change no gap."""
    share = len(diagnosis.outliers) / max(1, len(diagnosis.dataset.points))
    after = _mm(diagnosis.gap.after_m)
    return {
        "effect": "outliers",
        "where": "image",
        "probability": 1.0,
        "parameters": {"share": {"value": share, "std": None, "unit": ""}},
        "gap_mm_before": after,
        "gap_mm_after": after,
        "gap_mm_without": after,
        "indistinguishable_from": [],
    }
