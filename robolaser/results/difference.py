"""Two results of one kind side by side."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, final

import numpy as np

from robolaser.calibration.saved import numbers_of, read_result, robot_in, run_in
from robolaser.data.result_folder import write_text
from robolaser.errors import UsageError
from robolaser.report.console import printed
from robolaser.report.difference import document
from robolaser.report.page import render
from robolaser.robot.kinematics import Robot

if TYPE_CHECKING:
    import pandas as pd

FORMAT: Final = "robolaser-diff/1"
POSTURES: Final = 200  # at which two arms are compared
OF_THE_DATA: Final = ("dataset", "poses", "run")  # entries of a diagnosis, or a calibration, on its data
Fact = tuple[Any, str, float | None]  # an entry of a result by name: a value, its unit, and its standard error
ERRORS: Final = ("objective_m2", "rms_m", "max_m", "held_out_rms_m")


@final
class Difference(dict[str, Any]):
    """The difference of two results: `rows`, as `difference` has them; it prints as a table."""

    def to_frame(self) -> "pd.DataFrame":
        """A row for each entry."""
        import pandas as pd  # noqa: PLC0415 - half a second that the command does without

        return pd.DataFrame(self["rows"])

    def report(self, path: str | Path) -> None:
        """Write the page.

        Raises:
            OutputError: The file cannot be written.
        """
        write_text(Path(path), render(document(self)))

    def __repr__(self) -> str:
        """The output of `robolaser diff`."""
        return printed(document(self)).rstrip("\n")


def difference(first: str | Path, second: str | Path) -> Difference:
    """Compare two saved results of one kind, each by its folder or its JSON file, as `between` does.

    Raises:
        DataError: One cannot be read, or is no calibration and no diagnosis.
    """
    (before, one), (after, other) = map(_read, (first, second))
    return between(before, after, (one, other), (str(first), str(second)))


def _read(path: str | Path) -> tuple[dict[str, Any], Robot | None]:
    """A saved result, with the data entries of calibration.json beside a diagnosis; and its arm."""
    contents, _, folder = read_result(Path(path))
    return run_in(folder) | contents, robot_in(folder)


def between(
    before: Mapping[str, Any],
    after: Mapping[str, Any],
    arms: tuple[Robot | None, Robot | None],
    names: tuple[str, str] = ("this", "the other"),
) -> Difference:
    """Compare the contents of two results' JSON files, and both corrected arms; the names are for messages.

    Returns:
        `format`; `kind` of the results; `results`, their data sets; `same_data`, whether these are the same; and
        `rows`, each with the `name` of an entry, `first` and `second` (null where one has none), their `unit` if they
        have one, and for numbers their `change` and the change in standard errors of both, `errors`.

    Raises:
        UsageError: One is a calibration, the other a diagnosis.
    """
    kind, other = (f"{each['format']}{' of a moving arm' * (each.get('kind') == 'motion')}" for each in (before, after))
    if kind != other:
        raise UsageError(f"{names[0]} is of the format {kind}, {names[1]} of {other}: compare results of one kind.")
    rows = [*_compared(_errors(before), _errors(after)), *_at_flange(*arms)]
    rows += [*_compared(_numbers(before), _numbers(after)), *_compared(_probabilities(before), _probabilities(after))]
    sets = [before.get("dataset"), after.get("dataset")]
    same = all(before.get(key) == after.get(key) for key in OF_THE_DATA)
    return Difference({"format": FORMAT, "kind": before["format"], "results": sets, "same_data": same, "rows": rows})


def _compared(before: Mapping[str, Fact], after: Mapping[str, Fact]) -> Iterator[dict[str, Any]]:
    nothing: Fact = (None, "", None)
    for name in dict.fromkeys([*before, *after]):
        (first, unit, std), (second, other_unit, other_std) = before.get(name, nothing), after.get(name, nothing)
        row = {"name": name, "first": first, "second": second}
        if unit or other_unit:
            row["unit"] = unit or other_unit
        if isinstance(first, int | float) and isinstance(second, int | float):
            whole = 0.0 if std is None or other_std is None else float(np.hypot(std, other_std))
            row |= {"change": second - first, "errors": (second - first) / whole if whole > 0.0 else None}
        yield row


def _errors(result: Mapping[str, Any]) -> dict[str, Fact]:
    verdict = {"verdict": (result["verdict"], "", None)} if "verdict" in result else {}
    units = {"objective_m2": "m²"}
    errors = {name: (result.get(name), units.get(name, "m"), None) for name in ERRORS}
    gaps = {name: gap for name, gap in result.get("gap_mm", {}).items() if name != "after_ci95"}
    found = {**verdict, **errors, **{f"gap_mm.{name}": (gap, "mm", None) for name, gap in gaps.items()}}
    return {name: fact for name, fact in found.items() if fact[0] is not None}


def _at_flange(one: Robot | None, other: Robot | None) -> list[dict[str, Any]]:
    """Distance between the flanges of two corrected arms, root mean square over their joints' ranges."""
    if one is None or other is None or one.joints != other.joints:
        return []
    low, high = one.range
    q = np.random.default_rng(0).uniform(low, high, (POSTURES, len(one.joints)))
    apart = one.forward(q)[:, :3, 3] - other.forward(q)[:, :3, 3]
    moved = {"unit": "mm", "change": 1e3 * float(np.sqrt(np.square(apart).sum(axis=1).mean())), "errors": None}
    return [{"name": "flange of the corrected arm", "first": None, "second": None, **moved}]


def _numbers(result: Mapping[str, Any]) -> dict[str, Fact]:
    return {name: (one["value"], one.get("unit", ""), one["std"]) for name, one in numbers_of(result).items()}


def _probabilities(result: Mapping[str, Any]) -> dict[str, Fact]:
    of = {f"{one['effect']} at {one['where']}": one.get("probability") for one in result.get("effects", ())}
    of |= {f"class {one['class']}": one["probability"] for one in result.get("classes", ())}
    return {f"probability of {name}": (each, "", None) for name, each in of.items() if each is not None}
