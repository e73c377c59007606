"""The route of a recording: its poses in order, each with the configurations through which it is approached."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import read_json
from robolaser.data.csv_tables import CsvTable, bad_cell, read_table, table_text
from robolaser.data.data_tables import outside_limits
from robolaser.errors import DataError
from robolaser.robot.kinematics import Robot

KINDS = ("approach", "pose")


@final
@dataclass(frozen=True, eq=False)
class Waypoint:
    """One pose."""

    name: str  # unique
    q: Array  # joint values, (j,) [rad or m]
    approach: tuple[Array, ...] = ()  # configurations before it in order, (j,) each; none: from anywhere

    @property
    def approach_names(self) -> tuple[str, ...]:
        """Names of its approach in poses.csv."""
        several = len(self.approach) > 1
        return tuple(f"{self.name}_from{i if several else ''}" for i in range(1, len(self.approach) + 1))

    @property
    def places(self) -> tuple[tuple[str, Array], ...]:
        """Names and joint values of all configurations in order, the pose last."""
        return (*zip(self.approach_names, self.approach, strict=True), (self.name, self.q))


def numbered(q: Array) -> tuple[Waypoint, ...]:
    """Poses (n, j) under the names p001, p002, ..."""
    return tuple(map(Waypoint, pose_names("p", len(q)), q))


def pose_names(letter: str, count: int) -> list[str]:
    """p001, p002, ..."""
    digits = max(3, len(str(count)))
    return [f"{letter}{i:0{digits}d}" for i in range(1, count + 1)]


def from_table(path: Path, robot: Robot) -> tuple[Waypoint, ...]:
    """Poses of a CSV file with a column q_<joint> for each joint, and names where there is a column `pose`.

    Where there is a column `kind`, rows of kind "approach" are configurations on the way to the pose below.
    Without it, rows whose column `image` is empty are configurations that the arm only passed: they are left out.

    Raises:
        DataError: It has none, a value is in degrees or millimetres, or the file cannot be read; with row and column.
    """
    columns = [f"q_{joint}" for joint in robot.joints]
    table = read_table(path, columns)
    q = table.numbers(columns)
    outside_limits(table, q, robot)  # a plan slightly beyond is refused with all its violations
    waypoints = _grouped(table, q) if "pose" in table else numbered(q)
    images = () if "kind" in table or "image" not in table else table.cells("image")
    if any(images):
        waypoints = tuple(waypoint for waypoint, image in zip(waypoints, images, strict=True) if image)
    if not waypoints:
        raise _no_poses(path, "it has a header and no rows")
    return waypoints


def from_diagnosis(path: Path, robot: Robot) -> tuple[Waypoint, ...]:
    """The next poses that a diagnosis recommends; a DataError if there are none, or those of another robot."""
    diagnosis = read_json(path)
    try:
        q = [[float(pose[joint]) for joint in robot.joints] for pose in diagnosis["next_poses"]]
    except KeyError as error:
        raise _no_poses(path, f"it lacks {error}") from None
    except (TypeError, ValueError):
        raise _no_poses(path, "next_poses is not a list of joint values by name") from None
    if not q or not np.isfinite(q).all():
        raise _no_poses(path, "next_poses is empty: the diagnosis needs no more")
    return numbered(np.array(q))


def both_ways(waypoints: Sequence[Waypoint], run_up: float) -> tuple[Waypoint, ...]:
    """Each pose twice: with all joints coming from a run-up below, then from as far above [rad or m]."""
    return tuple(
        Waypoint(f"{waypoint.name}_{way}", waypoint.q, (waypoint.q + sign * run_up,))
        for waypoint in waypoints
        for way, sign in (("up", -1), ("down", 1))
    )


def way(waypoints: Sequence[Waypoint]) -> tuple[tuple[str, ...], Array]:
    """All configurations in order: their names, and joint values (m, j)."""
    places = [place for waypoint in waypoints for place in waypoint.places]
    return tuple(name for name, _ in places), np.array([q for _, q in places])


def route_text(robot: Robot, waypoints: Sequence[Waypoint]) -> str:
    """A route as a table that `from_table` and people read."""
    rows: list[list[object]] = []
    for waypoint in waypoints:
        rows += [[waypoint.name, "approach", *map(repr, place.tolist())] for place in waypoint.approach]
        rows.append([waypoint.name, "pose", *map(repr, waypoint.q.tolist())])
    return table_text(["pose", "kind", *(f"q_{joint}" for joint in robot.joints)], rows)


def _grouped(table: CsvTable, q: Array) -> tuple[Waypoint, ...]:
    """Rows of a table with names, and with kinds if it has that column; each pose with the approaches above it."""
    names = table.texts("pose")
    kinds = table.texts("kind") if "kind" in table else ["pose"] * len(names)
    waypoints: list[Waypoint] = []
    approach: list[Array] = []
    seen = set[str]()
    for i, (line, name, kind) in enumerate(zip(table.lines, names, kinds, strict=True)):
        if kind not in KINDS:
            raise bad_cell(table.file, line, "kind", kind, " or ".join(KINDS))
        if kind == "approach":
            if tuple(names[i + 1 : i + 2]) != (name,):
                raise bad_cell(table.file, line, "pose", name, "the name of the pose in the next row")
            approach.append(q[i])
            continue
        waypoint = Waypoint(name, q[i], tuple(approach))
        approach, names_of_it = [], {place for place, _ in waypoint.places}
        if taken := seen & names_of_it:
            raise bad_cell(table.file, line, "pose", name, f"a name that no row above has: {min(taken)} is taken")
        seen |= names_of_it
        waypoints.append(waypoint)
    return tuple(waypoints)


def _no_poses(path: Path, reason: str) -> DataError:
    return DataError(f"{path.name} gives no poses for this arm: {reason}.", file=path)
