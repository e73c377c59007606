"""A file with Denavit-Hartenberg numbers, CSV or TOML, written as a URDF; its units and convention are stated."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, final

from robolaser.data.csv_tables import finite, read_table
from robolaser.data.importers.importer import stated_units
from robolaser.data.toml_schema import read_toml, typed
from robolaser.errors import RobotError, UsageError, near
from robolaser.geometry.units import ANGLE, FACTORS, LENGTH
from robolaser.robot.by_name.description import Convention, rows_urdf

JOINT_KINDS = ("revolute", "prismatic", "fixed")
FLANGE = "flange"
QUANTITIES = {"a": LENGTH, "alpha": ANGLE, "d": LENGTH, "theta": ANGLE}
LIMITS = ("lower", "upper")
CENTRE = ("com_x", "com_y", "com_z")
MEASURED = (*QUANTITIES, *LIMITS, *CENTRE)
OTHERS = ("name", "kind", "mass_kg")
LARGEST = 1e4  # m or rad: larger numbers are mistakes


@final
@dataclass(frozen=True)
class DhFile:
    """A file's rows, with its convention and units."""

    joint: tuple[dict[str, Any], ...]
    convention: Literal["standard", "modified"] | None = None
    units: str | tuple[str, ...] = ()


def read_dh_table(path: Path, convention: Convention | None = None, units: Sequence[str] = ()) -> str:
    """A table's file as a URDF with the links `base`, `link_1` and so on, and `flange`.

    A row, from the base to the flange, is "standard" (Denavit, Hartenberg 1955) or "modified" (Craig), see `rows_urdf`.
    A CSV file has a row for each joint with the columns `a`, `alpha`, `d` and `theta`, and perhaps `name`, `kind`,
    `lower`, `upper`, `mass_kg`, `com_x`, `com_y`, `com_z`; a TOML file has `[[joint]]` tables with these
    keys, `convention` and `units`. A unit may end a name: `d_mm`, `alpha_deg`. The arguments count where the file does
    not state convention or units.

    Raises:
        RobotError: With row and column of a wrong or missing value; there is no moving joint, a prismatic one has no
            limits, or a fixed row has a mass.
        UsageError: The convention or a unit is stated nowhere.
        DataError: The file cannot be read, is no table, or has another key.
    """
    if path.suffix == ".toml":
        read = typed(read_toml(path), DhFile, file=path.name)
    else:
        table = read_table(path)
        cells = zip(*map(table.cells, table.columns), strict=True)
        read = DhFile(tuple(dict(zip(table.columns, row, strict=True)) for row in cells))
    known = read.convention or convention
    if known is None:
        raise UsageError(
            f"{path.name}: standard or modified (Craig's) Denavit-Hartenberg numbers? State `convention` in a TOML"
            " file, or --dh of `robolaser import`."
        )
    names = read.units.split(",") if isinstance(read.units, str) else read.units or units
    of_file = stated_units([name.strip() for name in names], path.name)
    rows = [_row(cells, number, of_file, path.name) for number, cells in enumerate(read.joint, 1)]
    if not any("joint" in row for row in rows):
        raise RobotError(f"{path.name}: the table has no joint that moves.")
    return rows_urdf(rows, known, path.stem, "base", FLANGE, first=1)


def _row(cells: Mapping[str, object], number: int, units: Mapping[str, str], file: str) -> dict[str, Any]:
    """A row for `rows_urdf`: a fixed one, as of a tool or a base, has no joint."""
    where = f"{file}, row {number}"
    kind = str(cells.get("kind") or "revolute")
    if kind not in JOINT_KINDS:
        raise RobotError(f"{where}: kind is {kind!r}.{near(kind, JOINT_KINDS)}")
    slides = kind == "prismatic"
    quantities = {**QUANTITIES, **dict.fromkeys(LIMITS, LENGTH if slides else ANGLE), **dict.fromkeys(CENTRE, LENGTH)}
    found: dict[str, float] = {}
    for column, cell in cells.items():
        name, unit = _split(column)
        if name in OTHERS or (name in MEASURED and cell == "" and name not in QUANTITIES):
            continue
        if name not in MEASURED:
            raise RobotError(f"{where}: no such column: {column}.{near(column, [*MEASURED, *OTHERS])}")
        if name in found:
            raise RobotError(f"{where}: {name} is there twice, in different units. Delete one.")
        quantity = quantities[name]
        value = _number(cell, f"{where}, column {column}")
        unit = unit or units.get(quantity, "")
        if unit not in FACTORS[quantity] and (unit or value):
            example = ", ".join(list(FACTORS[quantity])[:3])
            raise UsageError(
                f"{where}: in which unit is {column}? State it with --units ({example}), or at the end of the name, as"
                f" {name}_{next(iter(FACTORS[quantity]))}."
            )
        found[name] = FACTORS[quantity].get(unit, 0.0) * value
    missing = [name for name in QUANTITIES if name not in found]
    if missing:
        there = [_split(column)[0] for column in cells]
        raise RobotError(f"{where} lacks {', '.join(missing)}.{near(missing[0], there)}")
    row: dict[str, Any] = {f"{name}_{'m' if of == LENGTH else 'rad'}": found[name] for name, of in QUANTITIES.items()}
    joint, stated = str(cells.get("name") or f"joint_{number}"), cells.get("mass_kg")
    mass = 0.0 if stated in (None, "") else _number(stated, f"{where}, column mass_kg")
    if mass < 0:
        raise RobotError(f"{where}, column mass_kg: {mass:g}, expected zero or more.")
    if kind == "fixed":
        if mass > 0:
            raise RobotError(f"{where} is fixed and has a mass. Add it to the link of the joint before.")
        return row
    limits = {f"{end}_{'m' if slides else 'rad'}": found[end] for end in LIMITS if end in found}
    if len(limits) == 1 or (slides and not limits):
        what = "has one limit only" if limits else "slides without limits"
        raise RobotError(f"{where}: joint '{joint}' {what}. State its lower and upper limit.")
    com = [found.get(axis, 0.0) for axis in CENTRE]
    return row | limits | {"joint": joint, "slides": slides, "mass_kg": mass, "com_m": com}


def _split(column: str) -> tuple[str, str]:
    """A column's name, and the unit at its end or ""."""
    name, _, unit = column.rpartition("_")
    return (name, unit) if name in MEASURED and any(unit in known for known in FACTORS.values()) else (column, "")


def _number(cell: object, where: str) -> float:
    value = finite(str(cell))
    if not abs(value) <= LARGEST:
        raise RobotError(
            f"{where}: {str(cell)[:60]!r}, expected a number. Where a table has q or theta there, write the angle at"
            " which the joint's reading is zero."
        )
    return value
