"""Whether two data sets are of one arm, seen by one kind of sensor."""

from collections.abc import Iterator

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.errors import DataError

SAME = 1e-6  # [m, and of rotation matrices] URDFs that round their digits differ by less


def check_same_arm(one: Dataset, other: Dataset, purpose: str) -> None:
    """See that two data sets are of one arm, seen by one kind of sensor.

    Args:
        one: The first.
        other: The second, which is at fault where they differ.
        purpose: What the second cannot be, such as "predicted with what is found on cell".

    Raises:
        DataError: They are not; it says what differs.
    """
    differs = next(_differences(one, other), None)
    if differs:
        raise DataError(
            f"{other.name} cannot be {purpose}: {differs}. Both must be of the same arm, with the same joints, flange"
            " and kind of sensor.",
            file=other.folder or other.name,
        )


def _differences(one: Dataset, other: Dataset) -> Iterator[str]:
    if one.kind != other.kind:
        yield f'[sensor] kind is "{one.kind}" in {one.name} and "{other.kind}" in {other.name}'
    mine, theirs = ([(sensor.name, sensor.data.kind) for sensor in each.sensors] for each in (one, other))
    if mine != theirs:
        yield f"[[sensors]] are {_listed(mine)} in {one.name} and {_listed(theirs)} in {other.name}"
    a, b = one.robot, other.robot
    if a is None or b is None:
        if (a is None) != (b is None):
            yield f"only {one.name if b is None else other.name} has a [robot]"
        return
    if a.joints != b.joints:
        yield f"[robot] joints are {', '.join(a.joints)} in {one.name} and {', '.join(b.joints)} in {other.name}"
        return
    if a.flange != b.flange:
        yield f'[robot] flange is "{a.flange}" in {one.name} and "{b.flange}" in {other.name}'
    first, second = a.by_pinocchio, b.by_pinocchio
    if first.moving != second.moving:
        yield f"their URDFs move {', '.join(first.moving)} and {', '.join(second.moving)}"
        return
    apart = np.abs(first.placements - second.placements).max(axis=(1, 2))
    turned = np.abs(first.axes - second.axes).max(axis=1)
    for joint in np.flatnonzero(np.maximum(apart, turned) > SAME)[:1]:
        yield f"their URDFs place {first.moving[joint]} differently"
    if max(np.abs(first.ratios - second.ratios).max(), np.abs(first.offsets - second.offsets).max()) > SAME:
        yield "in their URDFs, joints follow others (mimic) by other numbers"
    if np.abs(a.end - b.end).max() > SAME:
        yield "their URDFs place the flange differently on the last joint"


def _listed(sensors: list[tuple[str, str]]) -> str:
    return ", ".join(f"{name} ({kind})" for name, kind in sensors) or "not there"
