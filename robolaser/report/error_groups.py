"""Errors by session, sensor, point and image: outliers among them, and each pose in the order of the run."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.calibration.result import rms
from robolaser.data.dataset import Dataset
from robolaser.geometry.mad_scale import mad_scale
from robolaser.report.chart import FITTED, HELD_OUT, NOISE, Chart, chart, colours, hover, layer, quantity, records, rule
from robolaser.report.digits import millimetres, times
from robolaser.report.document import Column, Content, Table, TableCell, Text

MOST_POINTS: Final = 60  # different names, up to which points are reflectors, sockets or balls, not of a stripe
LEAST_GROUPS: Final = 3  # fewest groups of which one can be odd
ODD: Final = 3.5  # robust standard deviations above the others beyond which a group is odd (Iglewicz and Hoaglin 1993)
LEAST_RATIO: Final = 1.5  # its error over the median, above which that is worth checking
NAMED: Final = 4
MOST_ROWS: Final = 60  # of the table: odd groups and the largest errors first
NOUNS: Final[Mapping[str, str]] = {"point": "reflector", "socket": "socket", "profile": "ball"}
"""The name of a point, by the kind of sensor."""


@final
@dataclass(frozen=True)
class ErrorGroup:
    """A group of rows."""

    kind: str  # "session", "sensor", "reflector", "socket", "ball", "point", "image" or "pose"
    name: str  # of the group
    rows: int  # how many rows
    rms_m: Sequence[float]  # root-mean-square error on fitted poses, then held-out where that is known [m]
    ratio: float  # the last of them over the median of the groups of its kind
    is_odd: bool  # is its error far larger than the others'?


def groups(dataset: Dataset, errors_m: Sequence[Array]) -> list[ErrorGroup]:
    """All groups of which there are several, kind by kind; the last errors (m, j) [m] decide which are odd."""
    return [group for kind, names, number in _kinds(dataset) for group in _groups(kind, names, number, errors_m)]


def group_blocks(dataset: Dataset, errors_m: Mapping[str, Array]) -> list[Content]:
    """Odd groups in a sentence, and all groups in a table; errors by name."""
    found = groups(dataset, list(errors_m.values()))
    if not found:
        return []
    named = [Column(f"RMS error, {name}") for name in errors_m]
    columns = [Column("Name", width=30), Column("Kind"), Column("Points"), *named, Column("Times the median")]
    rows: list[Sequence[TableCell | str]] = [
        (
            TableCell(one.name, note="odd" if one.is_odd else ""),
            one.kind,
            TableCell(f"{one.rows}", order=one.rows),
            *(TableCell(millimetres(size), order=size) for size in one.rms_m),
            TableCell(times(one.ratio), order=one.ratio),
        )
        for one in sorted(found, key=lambda one: (not one.is_odd, -one.ratio))[:MOST_ROWS]
    ]
    note = f"The {MOST_ROWS} largest of {len(found)}." if len(found) > MOST_ROWS else ""
    return [Text(sentence(found)), Table(columns, rows, fold=12, note=note)]


def sentence(found: Sequence[ErrorGroup]) -> str:
    """Which groups are odd, by how much."""
    odd = sorted((one for one in found if one.is_odd), key=lambda one: -one.ratio)
    if not odd:
        counted = {kind: sum(one.kind == kind for one in found) for kind in dict.fromkeys(one.kind for one in found)}
        listed = ", ".join(f"{count} {kind}s" for kind, count in counted.items())
        return f"No outlier among {listed}."
    texts = [f"{one.kind} {one.name} has an error of {millimetres(one.rms_m[-1])}, {times(one.ratio)} times the median"
            for one in odd[:NAMED]]  # fmt: skip
    more = f", and {len(odd) - NAMED} more" if len(odd) > NAMED else ""
    return f"Large errors: {'; '.join(texts)}{more}. Check these measurements."


def _kinds(dataset: Dataset) -> Iterator[tuple[str, Sequence[str], Ints]]:
    """Names of the groups of each kind, and the number of each row's group."""
    points, poses = dataset.points, dataset.poses
    if dataset.sessions is not None and poses.session is not None:
        yield "session", dataset.sessions.names, dataset.session_of_pose[points.pose]
    if len(dataset.sensors) > 1:
        yield "sensor", [sensor.name for sensor in dataset.sensors], dataset.sensor_of_row
    names = list(dict.fromkeys(points.names))
    if dataset.kind in NOUNS or (len(names) <= MOST_POINTS and dataset.kind == "camera"):
        yield NOUNS.get(dataset.kind, "point"), names, points.number
    yield "pose" if poses.image is None else "image", poses.names, points.pose


def _groups(kind: str, names: Sequence[str], number: Ints, errors_m: Sequence[Array]) -> list[ErrorGroup]:
    counts = np.bincount(number, minlength=len(names))
    squares = [np.bincount(number, (errors**2).sum(axis=1), minlength=len(names)) for errors in errors_m]
    seen = np.flatnonzero(counts)
    if len(seen) < 2:
        return []
    sizes = np.sqrt(np.stack(squares)[:, seen] / counts[seen])
    ratio = sizes[-1] / max(float(np.median(sizes[-1])), 1e-300)
    is_odd = _odd(ratio, counts[seen] * errors_m[-1].shape[1])
    return [
        ErrorGroup(kind, names[i], int(counts[i]), sizes[:, k].tolist(), float(ratio[k]), bool(is_odd[k]))
        for k, i in enumerate(seen.tolist())
    ]


def _odd(ratio: Array, numbers: Array) -> Array:
    """Which groups have far larger errors than the others, whose scatter is taken as chance at least."""
    if len(ratio) < LEAST_GROUPS:
        return np.zeros(len(ratio), dtype=bool)
    logs = np.log(np.maximum(ratio, 1e-12))
    above = logs - np.median(logs)
    score = above / np.maximum(mad_scale(above), 1 / np.sqrt(2 * numbers))
    return np.asarray((score > ODD) & (ratio > LEAST_RATIO))


FEW: Final = 80  # poses up to which dots are large
RINGS: Final = ("held out", "before")  # series that are drawn as rings, so that dots beneath them are visible
FLOOR: Final = "noise alone"


def pose_errors(
    dataset: Dataset, errors_m: Mapping[str, Array], *, reading: str, noise_m: float | None = None
) -> Chart:
    """Root-mean-square error of each pose, in the order of the run, and that by noise alone [m].

    Errors of all rows are by name, the last one ranks the poses [m]; `reading` explains them in the caption.
    """
    seen = np.unique(dataset.points.pose)
    time = dataset.poses.time_s
    seen = seen if time is None else seen[np.argsort(time[seen], kind="stable")]
    names = [dataset.poses.names[i] for i in seen]
    sizes = {name: [1e3 * rms(own[dataset.points.pose == i]) for i in seen] for name, own in errors_m.items()}
    title = "pose, in the order of " + ("poses.csv" if time is None else "the run")
    x, y = quantity("number", title, domain=(0, len(seen) + 1)), quantity("rms", "RMS error [mm]", log=True)
    of = {name: HELD_OUT if name in RINGS else FITTED for name in errors_m}
    colour = colours(of | ({} if noise_m is None else {FLOOR: NOISE}))
    dots = {"type": "point", "size": 46 if len(seen) <= FEW else 18}
    tooltip = hover("pose", "series", rms="RMS error [mm]")
    layers = [
        layer(dots | ({"filled": False, "strokeWidth": 1.4} if name in RINGS else {}),
              records(number=np.arange(1, len(seen) + 1), pose=names, rms=own, series=name),
              tooltip=tooltip, x=x, y=y, color=colour)
        for name, own in sizes.items()
    ]  # fmt: skip
    if noise_m is not None:
        floor = records(rms=1e3 * noise_m, series=FLOOR)
        layers.append(layer(rule(), floor, tooltip=hover("series", rms="RMS error [mm]"), y=y, color=colour))
    ranked = np.argsort(-np.array(list(sizes.values())[-1]), kind="stable")
    largest = [names[i] if names[i] == f"{i + 1}" else f"{names[i]} (at {i + 1})" for i in ranked[:3].tolist()]
    return chart(
        "Errors of each pose",
        f"{reading} A single high pose suggests a wrong measurement; a step or a slope along the run, a change during"
        f" the run. Largest: {', '.join(largest)}.",
        f"Errors of {len(seen)} poses; the largest is that of {names[ranked[0]]}.",
        layers,
    )
