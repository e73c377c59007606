"""Residual blocks: a sensor, the problem's names of its parameters, and its rows."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset, SensorData
from robolaser.model.sensors import sensors_of
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.stages import Perturbation
from robolaser.parameters import Parameter, Values

T = TypeVar("T")
THINGS = ("tool", "socket", "ball")
"""First parts of parameters that locate a named thing: it is the same for all sensors."""
LASER = ("b", "theta")  # parameters of a scanner that are not its camera's


@final
@dataclass(frozen=True, eq=False)
class Block:
    """The rows of one sensor in one session."""

    sensor: Sensor  # as for a data set of these rows and all poses
    named: Mapping[str, str]  # the problem's name of each of its parameters
    rows: Ints  # which of the data set's rows it saw, (m,)
    of_rows: int  # how many rows the data set has
    name: str = ""  # of the sensor, where there are several
    session: str = ""  # where there are several
    scale: float = 1.0  # a unit of its residuals in the problem's unit

    @property
    def is_whole(self) -> bool:
        """Whether it has all rows."""
        return len(self.rows) == self.of_rows

    @property
    def numbers(self) -> int:
        """Numbers of a row."""
        return self.sensor.format.numbers

    def values(self, values: Mapping[str, T]) -> dict[str, T]:
        """The sensor's parameters, by its own names."""
        return {own: values[whole] for own, whole in self.named.items() if whole in values}

    def of_problem(self, values: Mapping[str, T]) -> dict[str, T]:
        """The sensor's values by their names in the problem."""
        return {self.named[own]: value for own, value in values.items() if own in self.named}

    def perturbed(self, perturb: Perturbation) -> Perturbation:
        """The effects of the model for its rows."""
        return perturb if self.is_whole else perturb.of_rows(self.rows, self.of_rows)

    def at(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> tuple[Values, Array, Perturbation]:
        """The arguments of most functions of a sensor: its values, the flange, the effects."""
        return self.values(values), T_base_flange, self.perturbed(perturb)

    def scaled(self, residuals: Array) -> Array:
        """The sensor's residuals in the problem's unit."""
        return residuals if self.scale == 1.0 else self.scale * residuals

    def unscaled(self, residuals: Array) -> Array:
        """The problem's residuals (..., its rows, k) as the sensor has them, (..., its rows, its numbers)."""
        own = residuals[..., : self.numbers]
        return own if self.scale == 1.0 else own / self.scale


def blocks_of(dataset: Dataset) -> tuple[Block, ...]:
    """The blocks of a data set, sensor by sensor, each in the order of the sessions."""
    of_sensors = zip(dataset.sensors, sensors_of(dataset), strict=True)
    bare = [list(_in_sessions(dataset, *one)) for one in of_sensors]
    own = [dict.fromkeys(name for block in blocks for name in block.named) for blocks in bare]
    named = _names_in_problem(dataset.sensors, [tuple(names) for names in own])
    return tuple(
        _with_parameters(dataset, block, names) for blocks, names in zip(bare, named, strict=True) for block in blocks
    )


def _in_sessions(dataset: Dataset, seen: SensorData, sensor: Sensor) -> Iterator[Block]:
    """Blocks of one sensor, also where it has no rows; their parameters have the sensor's own names."""
    rows, m, name, scale = seen.rows, len(dataset.points), seen.name, seen.metres_per_unit
    sessions = dataset.sessions
    if sessions is None:
        yield Block(sensor, _own_names(sensor), rows, m, name, "", scale)
        return
    of_row = dataset.session_of_pose[dataset.points.pose[rows]]
    for at, session in enumerate(sessions.names):
        there = np.flatnonzero(of_row == at)
        if len(there) or not len(rows):
            points = sensor.dataset.points.take(there)
            one = type(sensor)(replace(sensor.dataset, points=points, sessions=None))
            yield Block(one, _own_names(one), rows[there], m, name, session, scale)


def _own_names(sensor: Sensor) -> dict[str, str]:
    return {name: name for name in sensor.parameters.names}


def _with_parameters(dataset: Dataset, block: Block, named: Mapping[str, str]) -> Block:
    """A block with the problem's names, and the values that the data set gives its sensor's parameters."""

    def in_problem(name: str) -> str:
        return dataset.sessions.named(name, block.session) if dataset.sessions else name

    # `left.base.x@SESSION` where `base.x` is `base.x@SESSION`
    names = {own: named[own] + in_problem(own).removeprefix(own) for own in block.named}
    given: dict[str, Parameter] = {}
    for own, whole in names.items():
        item = dataset.parameters.get(whole) or dataset.parameters.get(named[own])
        if item is not None:
            given[own] = replace(item, name=own)
    same = len(dataset.sensors) == 1 and dataset.sessions is None
    sensor = block.sensor if same else type(block.sensor)(replace(block.sensor.dataset, parameters=given))
    return replace(block, sensor=sensor, named=names)


def _names_in_problem(sensors: Sequence[SensorData], names: Sequence[Sequence[str]]) -> list[Mapping[str, str]]:
    """The problem's names of each sensor's parameters, by the sensor's own names.

    A target, a camera, a reflector, a socket or a ball that two sensors see has one set of parameters. Else a name that
    several sensors have is prefixed with the name of the sensor, its camera or its target: `left.base.x`.
    """
    owners: dict[str, set[str]] = {}
    for sensor, own in zip(sensors, names, strict=True):
        for name in own:
            owners.setdefault(name, set()).add(_owner(sensor, name))
    return [
        {name: name if len(owners[name]) == 1 else f"{_label(sensor, name)}.{name}" for name in own}
        for sensor, own in zip(sensors, names, strict=True)
    ]


def _owner(sensor: SensorData, name: str) -> str:
    """The thing that a parameter describes, the same text for the same thing."""
    head = name.partition(".")[0]
    if "." in name and head in THINGS:
        return head
    return f"{_kind_of_owner(sensor, name)} {_label(sensor, name)}"


def _label(sensor: SensorData, name: str) -> str:
    return {"target": sensor.target, "camera": sensor.camera}.get(_kind_of_owner(sensor, name), sensor.name)


def _kind_of_owner(sensor: SensorData, name: str) -> str:
    if name.startswith("target."):
        return "target"
    sees = "pixel" in sensor.data.format.columns
    return "camera" if sees and name not in LASER and not name.startswith("base.") else "sensor"
