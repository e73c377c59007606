"""The report of two results side by side: a page, and a table on the terminal."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from robolaser.diagnosis.cause_words import listed
from robolaser.report.digits import SIGNIFICANT, millimetres, percent, plain
from robolaser.report.document import Column, Document, Section, Table, TableCell

CLEAR: Final = 3.0  # standard errors above which a change among a dozen numbers is not chance
NAMED: Final = 4  # numbers that the first sentence names
ERRORS: Final = {
    "rms_m": "error on fitted poses", "max_m": "largest error on fitted poses", "held_out_rms_m": "error on new poses",
    "gap_mm.nominal": "error of the nominal model", "gap_mm.calibrated": "error after calibration alone",
    "gap_mm.after": "error with the effects", "gap_mm.noise_floor": "noise alone",
}  # fmt: skip
UNSAID: Final = ("objective_m2",)
OTHER_DATA: Final = "The results are of different data: a change may be one of the cell, or of what was measured."
PROBABILITY: Final = "probability of "
PAIR: Final = ("first", "second")
VALUE: Final = 5  # digits of a value
Row = Mapping[str, Any]


def document(found: Mapping[str, Any], names: tuple[str, str] = PAIR) -> Document:
    """The report on the output of `robolaser diff --json`, of two results with these names."""
    rows = [row for row in found["rows"] if row["name"] not in UNSAID]
    errors = [row for row in rows if row["name"] in ERRORS or row["name"] == "verdict"]
    numbers = [row for row in rows if "errors" in row and row not in errors and row.get("unit") != "mm"]
    sure = [row for row in rows if row["name"].startswith(PROBABILITY)]
    numbers = [row for row in numbers if row not in sure]
    alone = [row for row in rows if row not in (*errors, *numbers, *sure) and "change" not in row]
    heads = [Column("", "name", 34, ""), *(Column(name, "number", 0, name) for name in names)]
    columns = [*heads, Column("Change", "number", 0, "change")]

    def table(some: Sequence[Row], note: str = "") -> Table:
        return Table(columns, [_cells(row) for row in some], note=note, printed=len(some))

    in_brackets = "A change in brackets is in standard errors of both results together."
    return Document(
        " and ".join(dict.fromkeys(map(str, found["results"]))),
        "compared",
        f"{names[0]} beside {names[1]}",
        _lead(numbers),
        _sense(found, rows, names),
        [],
        [
            Section("Errors", [table(errors)]),
            Section("Numbers", [table(numbers, in_brackets)]),
            Section("In one of them only", [table(alone)]),
            Section("How sure", [table(sure)]),
        ],
        prints_lead=True,
    )


def _lead(numbers: Sequence[Row]) -> str:
    known = [row for row in numbers if row["errors"] is not None]
    moved = sorted((row for row in known if abs(row["errors"]) > CLEAR), key=lambda row: -abs(row["errors"]))
    if not known:
        return "No number with a standard error is in both results."
    if not moved:
        return f"None of {len(known)} numbers changed by more than {CLEAR:.0f} standard errors."
    some = [row["name"] for row in moved[:NAMED]]
    more = [f"{len(moved) - NAMED} more"] if len(moved) > NAMED else []
    return f"{listed([*some, *more])} changed by more than {CLEAR:.0f} standard errors."


def _sense(found: Mapping[str, Any], rows: Sequence[Row], names: tuple[str, str]) -> str:
    sentences = [] if found["same_data"] else [OTHER_DATA]
    for row in (row for row in rows if "change" in row):
        if row["name"] == "flange of the corrected arm":
            apart = millimetres(1e-3 * row["change"])
            sentences.append(f"The corrected arms have the flange {apart} apart (RMS over the joints' ranges).")
        if row["name"] in ("held_out_rms_m", "gap_mm.after"):
            first, second = (millimetres(row[each] * (1.0 if row["unit"] == "m" else 1e-3)) for each in PAIR)
            sentences.append(f"The error on new poses is {first} in {names[0]} and {second} in {names[1]}.")
    return " ".join(sentences)


def _cells(row: Row) -> tuple[TableCell, ...]:
    name, unit, apart = str(row["name"]), row.get("unit", ""), row.get("errors")
    is_sure = name.startswith(PROBABILITY)
    change = ""
    if row.get("change"):
        points = f"{plain(100.0 * row['change'], '', SIGNIFICANT)} %"
        change = points if is_sure else _value_text(row["change"], unit, SIGNIFICANT)
    if change and row["change"] > 0:
        change = f"+{change}"
    if change and apart is not None:
        change += f" ({abs(apart):.1f})"
    digits = SIGNIFICANT if name in ERRORS else VALUE
    values = [TableCell(_value_text(row[each], unit, digits, is_sure=is_sure)) for each in PAIR]
    return TableCell(ERRORS.get(name, name)), *values, TableCell(change, order=apart)


def _value_text(value: float | str | None, unit: str, digits: int, *, is_sure: bool = False) -> str:
    if value is None or isinstance(value, str):
        return value or "-"
    if is_sure:
        return percent(value)
    return plain(value * 1e-3, "m", digits) if unit == "mm" else plain(value, unit, digits)
