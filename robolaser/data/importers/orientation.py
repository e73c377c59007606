"""Euler angles and rotation vectors of people's files as the quaternions of poses.csv."""

from dataclasses import replace

from scipy.spatial.transform import Rotation

from robolaser.data.csv_tables import CsvTable
from robolaser.data.importers.column_choice import EULER, ROTATION_VECTOR, Chosen
from robolaser.data.sensor_format import QUATERNION
from robolaser.errors import UsageError
from robolaser.geometry.rigid_motion import exp_so3, to_quaternion


def with_quaternions(table: CsvTable, sequence: str | None) -> CsvTable:
    """The table with quaternions, if it has Euler angles or rotation vectors [rad] instead.

    Raises:
        UsageError: There are Euler angles, and the sequence is none.
    """
    if EULER[0] in table:
        try:
            R = Rotation.from_euler(sequence or "", table.numbers(EULER)).as_matrix()
        except ValueError:  # SciPy names the sequence, but not the option
            raise UsageError(
                f"--euler {sequence!r}: expected three axes, such as ZYX as they turn or zyx as they stay."
            ) from None
    elif ROTATION_VECTOR[0] in table:
        R = exp_so3(table.numbers(ROTATION_VECTOR))
    else:
        return table
    kept = {name: values for name, values in table.known.items() if name not in (*EULER, *ROTATION_VECTOR)}
    known = kept | dict(zip(QUATERNION, to_quaternion(R).T, strict=True))
    return replace(table, header=[*table.columns, *known], known=known)


def turned_by(chosen: Chosen, sequence: str | None) -> tuple[str, str]:
    """What says how the flange is turned, in words, and the first of its columns; empty texts for quaternions."""
    for columns, words in ((EULER, f"Euler angles {sequence}"), (ROTATION_VECTOR, "rotation vector")):
        if columns[0] in chosen:
            return f"{words} of {', '.join(chosen[column] for column in columns)}", chosen[columns[0]]
    return "", ""
