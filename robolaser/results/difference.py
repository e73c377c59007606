"""Two results of one kind side by side."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

import numpy as np

from robolaser.bounded_reading import read_json
from robolaser.data.atomic_write import write_text
from robolaser.errors import UsageError
from robolaser.report.console import printed
from robolaser.report.difference import document
from robolaser.report.page import render
from robolaser.results.contents import numbers_of, read_result, robot_in
from robolaser.robot.kinematics import Robot

if TYPE_CHECKING:
    import pandas as pd

FORMAT: Final = "robolaser-diff/1"
POSTURES: Final = 200
"""At which two arms are compared."""
OF_THE_DATA: Final = ("dataset", "poses", "run")
"""What a diagnosis, or a calibration, says of the data that it is of."""
ERRORS: Final = ("objective_m2", "rms_m", "max_m", "held_out_rms_m")


@final
class Difference(dict[str, Any]):
    """What two results say of the same things: `rows`, as `difference` has them; it prints as a table."""

    def to_frame(self) -> "pd.DataFrame":
        """A row for each thing."""
        import pandas as pd  # noqa: PLC0415 - half a second that the command does without

        return pd.DataFrame(self["rows"])

    def report(self, path: str | Path) -> None:
        """Write the page.

        Raises:
            OutputError: The file cannot be written.
        """
        write_text(Path(path), render(document(self)))

    def __repr__(self) -> str:
        """What `robolaser diff` prints."""
        return printed(document(self)).rstrip("\n")


def difference(first: str | Path, second: str | Path) -> Difference:
    """What two saved results say of the same things.

    Args:
        first: A result's folder, or its JSON file.
        second: Likewise, of the same kind.

    Raises:
        DataError: One cannot be read, or is no calibration and no diagnosis.
        UsageError: One is a calibration, the other a diagnosis.
    """
    before, after = ({**_of_run(Path(each)), **read_result(Path(each))[1]} for each in (first, second))
    arms = [robot_in(each if each.is_dir() else each.parent) for each in (Path(first), Path(second))]
    return between(before, after, arms, (str(first), str(second)))


def _of_run(path: Path) -> dict[str, Any]:
    """What calibration.json says of the data that a diagnosis beside it is of."""
    beside = path / "calibration.json"
    return {"run": read_json(beside).get("run")} if beside.is_file() else {}


def between(
    before: Mapping[str, Any],
    after: Mapping[str, Any],
    arms: Sequence[Robot | None] = (),
    names: tuple[str, str] = ("this", "the other"),
) -> Difference:
    """What two results say of the same things.

    Args:
        before: What a result's JSON file holds.
        after: Likewise, of the same kind.
        arms: The corrected arms of both.
        names: What a message calls them.

    Returns:
        `format`; `kind` of the results; `results`, their data sets; `same_data`, whether these are the same; and
        `rows`, each with the `name` of what is said, `first` and `second` (null where one says nothing), their `unit`
        where they have one, and for numbers their `change` and the change in standard errors of both, `errors`.

    Raises:
        UsageError: One is a calibration, the other a diagnosis.
    """
    kind, other = (each["format"] for each in (before, after))
    if kind != other:
        raise UsageError(f"{names[0]} is of the format {kind}, {names[1]} of {other}: compare results of one kind.")
    words = [] if "verdict" not in before else [_row("verdict", before["verdict"], after.get("verdict"))]
    rows = [*words, *_errors(before, after), *_at_flange(arms)]
    rows += [*_numbers(before, after), *_probabilities(before, after)]
    sets = [before.get("dataset"), after.get("dataset")]
    same = all(before.get(key) == after.get(key) for key in OF_THE_DATA)
    return Difference({"format": FORMAT, "kind": kind, "results": sets, "same_data": same, "rows": rows})


def _row(name: str, first: Any, second: Any, unit: str = "", errors: float | None = None) -> dict[str, Any]:
    are_numbers = all(isinstance(value, int | float) for value in (first, second))
    change = {"change": second - first, "errors": errors} if are_numbers else {}
    return {"name": name, "first": first, "second": second, **({"unit": unit} if unit else {}), **change}


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


def _at_flange(arms: Sequence[Robot | None]) -> list[dict[str, Any]]:
    """How far apart two corrected arms have the flange, root mean square over their joints' ranges."""
    one, other = arms if len(arms) == len(("one", "other")) else (None, None)
    if one is None or other is None or one.joints != other.joints:
        return []
    low, high = one.range
    q = np.random.default_rng(0).uniform(low, high, (POSTURES, len(one.joints)))
    apart = one.forward(q)[:, :3, 3] - other.forward(q)[:, :3, 3]
    moved = {"unit": "mm", "change": 1e3 * float(np.sqrt(np.square(apart).sum(axis=1).mean())), "errors": None}
    return [{"name": "flange of the corrected arm", "first": None, "second": None, **moved}]


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
