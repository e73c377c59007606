"""The recorded part of a calibration and of a diagnosis: results that users act on, in few digits."""

import math
from collections.abc import Mapping
from typing import Any

from robolaser.calibration.result import Calibration

OF_STD = 1e-2  # values are rounded to this fraction of their standard error
GAPS = ("nominal", "calibrated", "after", "noise_floor")


def calibrated(found: Calibration) -> dict[str, Any]:
    """Parameters with their standard errors, J, errors, and unidentifiable parameters."""
    free = zip(found.model.parameters.items, found.x.tolist(), found.std.tolist(), strict=True)
    return {
        "numbers": {item.name: _number(x, std) for item, x, std in free if not math.isnan(std)},
        "J": _short(found.objective_m2),
        "held_out_mm": None if found.held_out_rms_m is None else _short(1e3 * found.held_out_rms_m),
        "unidentifiable": [list(group.parameters) for group in found.unidentifiable],
    }


def diagnosed(found: Mapping[str, Any]) -> dict[str, Any]:
    """Verdict, gaps, effects with probability and size, classes, locations; as lists, to be short."""
    return {
        "verdict": found["verdict"],
        "gap_mm": {name: _short(found["gap_mm"][name]) for name in GAPS},
        "effects": [
            [
                item["effect"],
                item["where"],
                _short(item["probability"], 3),
                {name: _number(one["value"], one["std"]) for name, one in item["parameters"].items()},
                item["indistinguishable_from"],
            ]
            for item in found["effects"]
        ],
        "classes": [[item["class"], _short(item["probability"], 3)] for item in found["classes"]],
        "where": [[item["site"], _short(item["share"], 3)] for item in found["where"][:3]],
    }


def as_written(kept: Mapping[str, Any]) -> dict[str, Any]:
    """A recorded diagnosis with the keys of diagnosis.json, for `trials.score`."""
    return {
        "verdict": kept["verdict"],
        "gap_mm": kept["gap_mm"],
        "effects": [
            {
                "effect": effect,
                "where": where,
                "probability": probability,
                "parameters": {},
                "indistinguishable_from": alike,
            }
            for effect, where, probability, _, alike in kept["effects"]
        ],
        "classes": [{"class": name, "probability": probability} for name, probability in kept["classes"]],
        "where": [{"site": site, "share": share} for site, share in kept["where"]],
    }


def _number(value: float, std: float | None) -> list[float | None]:
    if std is None or not std > 0:
        return [_short(value), None]
    return [round(value, max(0, -math.floor(math.log10(OF_STD * std)))), _short(std, 3)]


def _short(value: float | None, digits: int = 5) -> float | None:
    return None if value is None or not math.isfinite(value) else float(f"{value:.{digits}g}")
