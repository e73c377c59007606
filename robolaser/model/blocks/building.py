"""The blocks of a data set: one for each sensor in each session that it saw something in."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from robolaser.data.dataset import Dataset, SensorData
from robolaser.model.blocks.block import Block
from robolaser.model.blocks.names import names_in_problem
from robolaser.model.sensors import sensors_of
from robolaser.model.sensors.sensor import Sensor
from robolaser.parameters import Parameter


def blocks_of(dataset: Dataset) -> tuple[Block, ...]:
    """The blocks of a data set, sensor by sensor, each in the order of the sessions."""
    of_sensors = zip(dataset.sensors, sensors_of(dataset), strict=True)
    bare = [list(_in_sessions(dataset, *one)) for one in of_sensors]
    own = [dict.fromkeys(name for block in blocks for name in block.named) for blocks in bare]
    named = names_in_problem(dataset.sensors, [tuple(names) for names in own])
    return tuple(
        _with_parameters(dataset, block, names) for blocks, names in zip(bare, named, strict=True) for block in blocks
    )


def _in_sessions(dataset: Dataset, seen: SensorData, sensor: Sensor) -> Iterator[Block]:
    """Blocks of one sensor; their parameters have the sensor's own names."""
    rows, m, name, scale = seen.rows, len(dataset.points), seen.name, seen.metres_per_unit
    sessions = dataset.sessions
    if sessions is None:
        yield Block(sensor, _own_names(sensor), rows, m, name, "", scale)
        return
    of_row = dataset.session_of_pose[dataset.points.pose[rows]]
    for at, session in enumerate(sessions.names):
        there = np.flatnonzero(of_row == at)
        if len(there):
            points = sensor.dataset.points.take(there)
            one = type(sensor)(replace(sensor.dataset, points=points, sessions=None))
            yield Block(one, _own_names(one), rows[there], m, name, session, scale)


def _own_names(sensor: Sensor) -> dict[str, str]:
    return {name: name for name in sensor.parameters.names}


def _with_parameters(dataset: Dataset, block: Block, named: Mapping[str, str]) -> Block:
    """A block with the problem's names, and with what the data set says of its sensor's parameters."""

    def in_problem(name: str) -> str:
        return dataset.sessions.named(name, block.session) if dataset.sessions else name

    names = {own: in_session(named[own], own, in_problem(own)) for own in block.named}
    given: dict[str, Parameter] = {}
    for own, whole in names.items():
        item = dataset.parameters.get(whole) or dataset.parameters.get(named[own])
        if item is not None:
            given[own] = replace(item, name=own)
    same = len(dataset.sensors) == 1 and dataset.sessions is None
    sensor = block.sensor if same else type(block.sensor)(replace(block.sensor.dataset, parameters=given))
    return replace(block, sensor=sensor, named=names)


def in_session(whole: str, own: str, own_in_session: str) -> str:
    """The problem's name of a parameter in a session: `left.base.x@SESSION` where `base.x` is `base.x@SESSION`."""
    return whole + own_in_session.removeprefix(own)
