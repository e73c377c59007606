"""What all sensors would see at other poses than those measured."""

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Points
from robolaser.data.several_sensors import with_points_of
from robolaser.model.blocks.blocks import Blocks
from robolaser.parameters import Values


def seen_from(blocks: Blocks, values: Values, T_base_flange: Array) -> tuple[Points, Bools] | None:
    """What would be measured at other poses, things as they are in the last session; None where one cannot tell.

    Args:
        blocks: Of the problem.
        values: All parameters.
        T_base_flange: (p, 4, 4).

    Returns:
        Rows of one pose after the other, as many of each, numbered from 0; and which poses see all of theirs, (p,).
    """
    last = [of_sensor[-1] for of_sensor in blocks.by_sensor]
    each = [one.sensor.new_poses.seen_from(one.values(values), T_base_flange) for one in last]
    seen = [one for one in each if one is not None]
    if len(seen) < len(last):
        return None
    if len(seen) == 1:
        return seen[0]
    points = with_points_of(blocks.dataset, [points for points, _ in seen]).points
    order = np.argsort(points.pose, kind="stable")
    return points.take(order), np.logical_and.reduce([good for _, good in seen])


def aims(blocks: Blocks, values: Values, T_base_flange: Array) -> tuple[Array, Array] | None:
    """Places on the flange, (a, 3), and where each must come for the only sensor to see something; None: anywhere."""
    last = blocks.one_sensor[-1:]
    return last[0].sensor.new_poses.aims(last[0].values(values), T_base_flange) if last else None
