"""Two results of one kind side by side."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from robolaser.bounded_reading import read_json
from robolaser.calibration.result import FORMAT as CALIBRATION
from robolaser.diagnosis.result_json import FORMAT as DIAGNOSIS
from robolaser.errors import DataError, UsageError
from robolaser.results import numbers_of

FORMAT: Final = "robolaser-diff/1"
FILES: Final = {CALIBRATION: "calibration.json", DIAGNOSIS: "diagnosis.json"}
ERRORS: Final = ("objective_m2", "rms_m", "max_m", "held_out_rms_m")


def difference(first: str | Path, second: str | Path) -> dict[str, Any]:
    """What two results say of the same things.

    Args:
        first: A result's folder, or its JSON file.
        second: Likewise, of the same kind.

    Returns:
        `format`; `kind` of the results; `results`, their data sets; and `rows`, each with the `name` of what is said,
        `first` and `second` (null where one says nothing), and for numbers their `unit`, `change` and the change
        in standard errors of both, `errors`.

    Raises:
        DataError: One cannot be read, or is no calibration and no diagnosis.
        UsageError: One is a calibration, the other a diagnosis.
    """
    kind, before = read_result(Path(first))
    other, after = read_result(Path(second))
    if kind != other:
        raise UsageError(f"{first} is of the format {kind}, {second} of {other}: compare results of one kind.")
    words = [] if "verdict" not in before else [_row("verdict", before["verdict"], after.get("verdict"))]
    rows = [*words, *_errors(before, after), *_numbers(before, after), *_probabilities(before, after)]
    return {"format": FORMAT, "kind": kind, "results": [before.get("dataset"), after.get("dataset")], "rows": rows}


def read_result(path: Path) -> tuple[str, Mapping[str, Any]]:
    """Format and contents of a result in a folder, or of its JSON file.

    Raises:
        DataError: It cannot be read, or is no calibration and no diagnosis.
    """
    there = [path / name for name in FILES.values() if (path / name).is_file()] if path.is_dir() else [path]
    if not there:
        raise DataError(f"{path} holds no result: neither {' nor '.join(FILES.values())} is there.")
    file = there[-1]  # of a diagnosis, which has both
    contents = read_json(file)
    found = contents.get("format") if isinstance(contents, dict) else None
    if found not in FILES or not isinstance(contents, dict):
        raise DataError(f"{file}: expected the format {' or '.join(FILES)}, not {found!r}.", file=file.name)
    return found, contents


def _row(name: str, first: Any, second: Any, unit: str = "", errors: float | None = None) -> dict[str, Any]:
    are_numbers = all(isinstance(value, int | float) for value in (first, second))
    change = {"unit": unit, "change": second - first, "errors": errors} if are_numbers else {}
    return {"name": name, "first": first, "second": second, **change}


def _errors(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[dict[str, Any]]:
    units = {"objective_m2": "m²"}
    rows = [
        _row(name, before.get(name), after.get(name), units.get(name, "m"))
        for name in ERRORS
        if name in before or name in after
    ]
    gaps = [result.get("gap_mm", {}) for result in (before, after)]
    known = [name for name in dict.fromkeys([*gaps[0], *gaps[1]]) if not name.endswith("ci95")]
    return [*rows, *(_row(f"gap_mm.{name}", gaps[0].get(name), gaps[1].get(name), "mm") for name in known)]


def _numbers(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[dict[str, Any]]:
    rows, numbers = [], [numbers_of(before), numbers_of(after)]
    for name in dict.fromkeys([*numbers[0], *numbers[1]]):
        one, two = (each.get(name) for each in numbers)
        deviations = [each["std"] for each in (one, two) if each is not None]
        is_known = one is not None and two is not None and all(deviation is not None for deviation in deviations)
        whole = float(np.hypot(*deviations)) if is_known else 0.0
        errors = (two["value"] - one["value"]) / whole if one and two and whole > 0.0 else None
        unit = (one or two or {}).get("unit", "")
        rows.append(_row(name, one and one["value"], two and two["value"], unit, errors))
    return rows


def _probabilities(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[dict[str, Any]]:
    def of(result: Mapping[str, Any]) -> dict[str, float]:
        effects = {
            f"probability of {one['effect']} at {one['where']}": one["probability"]
            for one in result.get("effects", ())
            if "probability" in one
        }
        classes = {f"probability of class {one['class']}": one["probability"] for one in result.get("classes", ())}
        return effects | classes

    first, second = of(before), of(after)
    return [_row(name, first.get(name), second.get(name)) for name in dict.fromkeys([*first, *second])]
