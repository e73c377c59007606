"""The data format of a kind of sensor: its columns of points.csv, its keys of dataset.toml, its units."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Literal, final

from robolaser.data.toml_schema import wrong

POSE_UNITS = {"x": "m", "y": "m", "z": "m", "w": "rad", "phi": "rad", "psi": "rad"}
"""Units of the six parameters of a rigid motion, by the last part of their names."""
PIXEL = ("u_px", "v_px")
XYZ = ("x_m", "y_m", "z_m")
QUATERNION = ("qx", "qy", "qz", "qw")
Mount = Literal["flange", "base"]  # the sensor's mount
SENSORS = "robolaser.model.sensors"  # imports this file, and all sensors of robolaser and installed packages


@final
@dataclass(frozen=True)
class SensorFormat:
    """The data format of a kind of sensor; a sensor's class declares it.

    Attributes:
        kind: Its name in `[sensor] kind`.
        title: Its name in messages and reports, without an article: "laser stripe scanner".
        task: A clause for reports: "the model predicts measurements" 0.1 mm off.
        columns: The arrays of `Points` that every row has, by name, and their columns of points.csv. `pixel` and `xyz`
            are arrays that all sensors share; others are in `Points.columns`. `quaternion` holds rotations.
        absent: Forbidden columns of points.csv, each with a reason.
        numbers: How many numbers the residual of a row has.
        unit: Their unit.
        angles: How many of them, the last ones, are angles instead [rad].
        tables: Tables of dataset.toml that it reads, beyond those that every data set may have: some of "scanner",
            "image", "board". Others are reported as unused.
        required: Those of them that are mandatory.
        options: Frozen dataclass of its keys in `[sensor]` besides `kind`, annotated as msgspec reads them; its
            instance is `Dataset.options`.
        units: Units of its parameters, by name or by the last part of a dotted name; the six of a rigid motion are
            known.
        positive: Parameters whose lower bound must be above zero.
        many_rows: Whether a point has many rows in a pose, which are positions along it: those of a profile on a ball.
        balls: Whether names are those of balls, whose radii `[target] radius_m` must state.
        named_points: Where a point's name means the same point at every pose, the first part of the parameters that
            hold its place: "socket" where these are `socket.NAME.x`, `.y` and `.z`. `[target] distances_m` may then be
            stated.
        tracker: Whether it is fixed in the cell and measures in its own frame, which `base.*` places: known points
            are in that frame, and a pose may have a small rigid error, beyond that of the joint readings.
        lens: Parameters of the lens that it fits where the data set does not fix them, of `k2`, `k3`, `p1` and `p2`:
            they need no effect of the lens.
        needs_robot: Whether it needs joint angles.
    """

    kind: str
    title: str
    columns: Mapping[str, tuple[str, ...]]
    absent: Mapping[str, str] = field(default_factory=dict)
    task: str = "the model predicts measurements"
    numbers: int = 3
    unit: str = "m"
    angles: int = 0
    tables: tuple[str, ...] = ()
    required: tuple[str, ...] = ()
    options: type | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    positive: tuple[str, ...] = ()
    many_rows: bool = False
    balls: bool = False
    named_points: str = ""
    tracker: bool = False
    lens: tuple[str, ...] = ()
    needs_robot: bool = False

    def unit_of(self, parameter: str) -> str:
        """The SI unit of one of its parameters; "" for a pure number."""
        last = parameter.rsplit(".", 1)[-1]
        known = self.units.get(parameter) or self.units.get(last) or POSE_UNITS.get(last, "")
        plain, at, _ = parameter.rpartition("@")
        return known or (self.unit_of(plain) if at else "")


def format_of_several(formats: Sequence[SensorFormat]) -> SensorFormat:
    """The format of several sensors of one data set; rows have as many numbers as the largest one's, in metres."""
    first, counts = formats[0], Counter(one.title for one in formats)
    *others, last = (title if count == 1 else f"{count} × {title}" for title, count in counts.items())
    return SensorFormat(
        kind=first.kind,
        title=f"{', '.join(others)} and {last}" if others else last,
        columns={name: columns for one in formats for name, columns in one.columns.items()},
        numbers=max(one.numbers for one in formats),
        tables=tuple(dict.fromkeys(table for one in formats for table in one.tables)),
        units={name: unit for one in formats for name, unit in one.units.items()},
        positive=tuple(dict.fromkeys(name for one in formats for name in one.positive)),
        named_points=first.named_points if all(one.named_points for one in formats) else "",
        needs_robot=any(one.needs_robot for one in formats),
    )


def sensor_kinds() -> tuple[str, ...]:
    """The kinds that can be read."""
    return tuple(import_module(SENSORS).sensors())


def sensor_format(kind: str) -> SensorFormat:
    """The format of a kind of sensor."""
    known = import_module(SENSORS).REGISTERED
    is_known = isinstance(kind, str) and kind in known  # a file may state anything
    if not is_known and kind not in sensor_kinds():
        kinds = (*sensor_kinds(), "motion")  # a moving arm's log has no sensor
        expected = " or ".join(f'"{known}"' for known in kinds)
        raise wrong("dataset.toml", ("sensor", "kind"), kind, expected, kinds)
    declared: SensorFormat = known[kind].format
    return declared
