"""Noise sources of the rows of all blocks: errors of rows, and small motions of whole poses."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.duals import Dual
from robolaser.geometry.rigid_motion import skew
from robolaser.model.blocks.block import Block
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.error_source import ErrorSource, along_each_axis
from robolaser.model.grouped_rows import group_means
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values


def row_errors(blocks: Blocks, values: Values, T_base_flange: Array, perturb: Perturbation) -> tuple[ErrorSource, ...]:
    """Noise sources of single rows, at one candidate; of several sensors named `SENSOR.pixel`.

    A source moves only rows of its sensor, and rows of different sessions share no errors.
    """
    at = values, T_base_flange, perturb
    return tuple(
        _source(blocks, of_sensor, sources)
        for of_sensor in blocks.by_sensor
        for sources in zip(*(block.sensor.row_errors(*block.at(*at)) for block in of_sensor), strict=True)
    )


def _source(blocks: Blocks, of_sensor: Sequence[Block], sources: Sequence[ErrorSource]) -> ErrorSource:
    """One source of a sensor for the rows of the problem."""
    first, m, of_pose = sources[0], len(blocks.dataset.points), blocks.dataset.points.pose
    if of_sensor[0].is_whole:
        return first
    name = f"{of_sensor[0].name}.{first.name}" if of_sensor[0].name else first.name
    if len(blocks.by_sensor) == 1 and all(source.isotropic for source in sources):
        effect = along_each_axis(m, blocks.numbers)
    else:
        effect = np.zeros((m, blocks.numbers, first.effect.shape[2]))
        for block, source in zip(of_sensor, sources, strict=True):
            effect[block.rows, : block.numbers] = block.scaled(source.effect)
    pairs = list(zip(of_sensor, sources, strict=True))
    if all(np.array_equal(source.group, of_pose[block.rows]) for block, source in pairs):
        return replace(first, name=name, effect=effect, group=of_pose)
    group, before = np.full(m, -1, dtype=np.int64), 0
    for block, source in pairs:
        _, number = np.unique(source.group, return_inverse=True)
        group[block.rows] = before + number
        before += int(number.max()) + 1
    others = np.flatnonzero(group < 0)
    group[others] = before + np.arange(len(others))
    return replace(first, name=name, effect=effect, group=group)


def moved_with_pose(blocks: Blocks, values: Values, T_base_flange: Array, perturb: Perturbation) -> tuple[Array, Array]:
    """Move of each row by shifts and by turns of its pose, one candidate, (m, k, 3) [unit/m] and [unit/rad].

    Turns are about the middle of the pose's points, or about the flange where points are unknown: there shift and turn
    are distinguishable, and neither grows to cancel the other over the arm between.
    """
    at = values, T_base_flange, perturb
    known, declared = blocks.known(*at) if blocks.one_sensor else None, blocks.sensor.format
    if known is not None and declared.unit == "m" and declared.numbers - declared.angles == 3:
        return _rigid_moves(known[0], blocks.dataset.points.pose, declared.numbers)
    flange = _in_six_ways(T_base_flange, _pivots(blocks, *at))
    moved: Any = blocks.residuals(values, cast("Array", flange), perturb)
    slopes = np.moveaxis(moved.slopes[:, 0], 0, -1)
    return slopes[..., :3], slopes[..., 3:]


def _pivots(blocks: Blocks, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
    """The middle of the points that are known in the base frame at each pose; else the flange, (n, 3) [m]."""
    pivot: Array = T_base_flange[0, :, :3, 3].copy()
    points, of_pose = [np.empty((0, 3))], [np.empty(0, dtype=np.int64)]
    for block in blocks:
        known = block.sensor.known(*block.at(values, T_base_flange, perturb))
        if known is not None and not block.sensor.format.tracker:
            points.append(known[0])
            of_pose.append(block.sensor.dataset.points.pose)
    number = np.concatenate(of_pose)
    middle = group_means(np.concatenate(points), number, len(pivot))
    seen = np.bincount(number, minlength=len(pivot)) > 0
    pivot[seen] = middle[seen]
    return pivot


def _rigid_moves(points: Array, of_pose: Ints, numbers: int) -> tuple[Array, Array]:
    """Moves of rows by shifts and turns of their pose about the middle of its points, (m, numbers, 3) each.

    A row has three numbers, its point (m, 3) [m] less the predicted one, and may have three more, the turn between.
    """
    arms = points - group_means(points, of_pose)[of_pose]
    if numbers == 3:
        return along_each_axis(len(points), 3), skew(arms)
    shifts, turns = np.zeros((2, len(points), numbers, 3))
    shifts[:, :3] = turns[:, 3:] = np.eye(3)
    turns[:, :3] = -skew(arms)
    return shifts, turns


def _in_six_ways(T_base_flange: Array, pivot: Array) -> Dual:
    """Poses (c or 1, n, 4, 4) that may be shifted along the base's axes, or turned about them at pivots (n or 1, 3)."""
    slopes = np.zeros((6, *T_base_flange.shape))
    slopes[:3, ..., :3, 3] = np.eye(3)[:, None, None]
    arms = T_base_flange[..., :3, :].copy()
    arms[..., 3] -= pivot
    slopes[3:, ..., :3, :] = skew(np.eye(3))[:, None, None] @ arms
    return Dual(T_base_flange, slopes, tuple(range(6)))
