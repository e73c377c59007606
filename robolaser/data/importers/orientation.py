"""Euler angles and rotation vectors of people's files as the quaternions of poses.csv."""

from dataclasses import replace

from robolaser.arrays import Array
from robolaser.data.csv_tables import CsvTable
from robolaser.data.importers.column_choice import EULER, ROTATION_VECTOR, Chosen
from robolaser.data.sensor_format import QUATERNION
from robolaser.errors import UsageError
from robolaser.geometry.rigid_motion import exp_so3, rot_x, rot_y, rot_z, to_quaternion

TURNS = {"x": rot_x, "y": rot_y, "z": rot_z}


def with_quaternions(table: CsvTable, sequence: str | None) -> CsvTable:
    """The table with quaternions, if it has Euler angles or rotation vectors [rad] instead.

    Raises:
        UsageError: There are Euler angles, and the sequence is none.
    """
    if EULER[0] in table:
        R = euler_rotations(table.numbers(EULER), sequence or "")
    elif ROTATION_VECTOR[0] in table:
        R = exp_so3(table.numbers(ROTATION_VECTOR))
    else:
        return table
    kept = {name: values for name, values in table.known.items() if name not in (*EULER, *ROTATION_VECTOR)}
    known = kept | dict(zip(QUATERNION, to_quaternion(R).T, strict=True))
    return replace(table, header=[*table.columns, *known], known=known)


def euler_rotations(angles: Array, sequence: str) -> Array:
    """Rotations by three angles (n, 3) [rad] -> (n, 3, 3).

    Args:
        angles: In the order of the sequence.
        sequence: As in SciPy: "ZYX" about the axes as they turn, R_z R_y R_x; "zyx" about those that stay, R_x R_y R_z.

    Raises:
        UsageError: It is no sequence of three axes.
    """
    axes = sequence.lower()
    alike = sequence in (axes, sequence.upper())
    if not (alike and len(axes) == 3 and set(axes) <= set(TURNS) and axes[0] != axes[1] != axes[2]):
        raise UsageError(f"--euler {sequence!r}: expected three axes, such as ZYX as they turn or zyx as they stay.")
    first, second, third = (TURNS[axis](angles[:, i]) for i, axis in enumerate(axes))
    R: Array = first @ second @ third if sequence.isupper() else third @ second @ first
    return R


def turned_by(chosen: Chosen, sequence: str | None) -> tuple[str, str]:
    """What says how the flange is turned, in words, and the first of its columns; empty texts for quaternions."""
    for columns, words in ((EULER, f"Euler angles {sequence}"), (ROTATION_VECTOR, "rotation vector")):
        if columns[0] in chosen:
            return f"{words} of {', '.join(chosen[column] for column in columns)}", chosen[columns[0]]
    return "", ""
