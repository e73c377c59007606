"""The columns of one table of a data set, read from a file of another form."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.data.csv_tables import Cells, CsvTable, bad_cell, finite
from robolaser.data.dataset import COMMAND
from robolaser.data.importers.column_choice import EULER, POINTS, ROTATION_VECTOR, TEXT, Chosen, Quantities
from robolaser.data.importers.importer import ImportOptions, Reading
from robolaser.data.importers.units import Units
from robolaser.data.sensor_format import QUATERNION
from robolaser.errors import UsageError
from robolaser.geometry.rigid_motion import exp_so3, to_quaternion
from robolaser.geometry.units import ANGLE


@final
@dataclass(frozen=True)
class ColumnReader:
    """The columns of one table of the data set, and how they are read from a file."""

    name: str
    file: CsvTable
    chosen: Chosen
    quantities: Quantities
    options: ImportOptions

    def table(self, *, number_poses: bool) -> CsvTable:
        """The columns by their names in the data set, numbers in SI units."""
        units = Units.of(self.options.units_in(self.file.file))
        columns: dict[str, Cells] = {}
        for column, source in self.chosen.items():
            quantity = self.quantities.get(column, TEXT)
            if quantity is TEXT:
                columns[column] = self._texts(column, source)
            elif column.startswith(COMMAND):  # kept as a further column, though it has a unit
                columns[column] = tuple(map(repr, (units.factor(quantity, source) * self._numbers(source)).tolist()))
            else:
                columns[column] = units.factor(quantity, source) * self._numbers(source)
        if number_poses and "pose" not in self.chosen:
            columns["pose"] = tuple(map(str, self.file.lines))
        if self.name == POINTS and "point" not in self.chosen:
            columns["point"] = (self.options.point or "",) * len(self.file)
        return CsvTable(self.file.file, columns, self.file.lines)

    def readings(self, *, number_poses: bool) -> list[Reading]:
        """How each column is read."""
        table, file = f"{self.name}.csv", self.file.file
        units = Units.of(self.options.units_in(file))
        found = []
        for column, source in self.chosen.items():
            quantity = self.quantities.get(column, TEXT)
            unit = "" if quantity is TEXT else units.unit(quantity, source)
            if column not in (*EULER, *ROTATION_VECTOR):
                found.append(Reading(table, column, file, source, f"{unit}/s" if column.startswith("qd_") else unit))
        words, first = _turned_by(self.chosen, self.options.euler)
        if words:
            found += [Reading(table, column, file, words, units.unit(ANGLE, first)) for column in QUATERNION]
        if number_poses and "pose" not in self.chosen:
            found.insert(0, Reading(table, "pose", file, "(number of the row)"))
        if self.name == POINTS and "point" not in self.chosen:
            found.append(Reading(table, "point", file, "(--point)"))
        return found

    def _texts(self, column: str, source: str) -> tuple[str, ...]:
        cells = self.file.cells(source)
        if column in self.quantities:
            return cells
        plain = tuple(self._plain(cell) for cell in cells)  # a further column, perhaps of numbers
        return plain if np.isfinite([finite(cell) for cell in plain]).all() else cells

    def _numbers(self, source: str) -> Array:
        cells = self.file.cells(source)
        values = np.array([finite(self._plain(cell)) for cell in cells], dtype=np.float64)
        for i in np.flatnonzero(~np.isfinite(values))[:1]:
            sign = self.options.decimal
            other = "," if sign == "." else "."
            hint = f" with the decimal sign {sign!r} (--decimal says another)" if other in cells[i] else ""
            raise bad_cell(self.file.file, self.file.lines[i], source, cells[i], f"a finite number{hint}")
        return values

    def _plain(self, cell: str) -> str:
        """A cell with a decimal point; one that had a point beside another sign is no number."""
        sign = self.options.decimal
        return cell if sign == "." else f"'{cell}'" if "." in cell else cell.replace(sign, ".")


def with_quaternions(table: CsvTable, sequence: str | None) -> CsvTable:
    """The table with quaternions, if it has Euler angles or rotation vectors [rad] instead.

    Raises:
        UsageError: There are Euler angles, and the sequence is none.
    """
    if EULER[0] in table:
        try:
            angles = table.numbers(EULER)  # older versions of SciPy refuse none
            R = Rotation.from_euler(sequence or "", angles).as_matrix() if len(angles) else np.empty((0, 3, 3))
        except ValueError:  # SciPy names the sequence, but not the option
            raise UsageError(
                f"--euler {sequence!r}: expected three axes, such as ZYX (rotating) or zyx (fixed)."
            ) from None
    elif ROTATION_VECTOR[0] in table:
        R = exp_so3(table.numbers(ROTATION_VECTOR))
    else:
        return table
    kept = {name: cells for name, cells in table.columns.items() if name not in (*EULER, *ROTATION_VECTOR)}
    return replace(table, columns=kept | dict(zip(QUATERNION, to_quaternion(R).T, strict=True)))


def _turned_by(chosen: Chosen, sequence: str | None) -> tuple[str, str]:
    """What says how the flange is turned, in words, and the first of its columns; empty texts for quaternions."""
    for columns, words in ((EULER, f"Euler angles {sequence}"), (ROTATION_VECTOR, "rotation vector")):
        if columns[0] in chosen:
            return f"{words} of {', '.join(chosen[column] for column in columns)}", chosen[columns[0]]
    return "", ""
