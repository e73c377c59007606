"""Ways to measure, one file each.

A custom sensor is a subclass of `Sensor`, defined anywhere before a data set of its kind is read; or an installed
package announces it by an entry point in the group `robolaser.sensors`.
"""

from dataclasses import replace
from functools import cache

from robolaser.data.dataset import Dataset, SensorData
from robolaser.model.sensors.camera import CameraSensor
from robolaser.model.sensors.point import Point
from robolaser.model.sensors.pose import Pose
from robolaser.model.sensors.profile import Profile
from robolaser.model.sensors.scanner_corners import ScannerCorners, scanner_of, seen_by
from robolaser.model.sensors.sensor import REGISTERED, Sensor
from robolaser.model.sensors.socket import Socket
from robolaser.model.sensors.stripe import Stripe
from robolaser.parameters import Parameter
from robolaser.plugins import announced

NOT_THE_SCANNERS = {name: Parameter(name, "", 0.0, 0.0, 0.0) for name in ("k2", "k3", "p1", "p2")}
"""Lens terms of a camera that a stripe scanner's does not have."""


def sensors() -> dict[str, type[Sensor]]:
    """Every kind of sensor by name: ours, then announced and defined ones.

    Raises:
        PluginError: What an installed package announces cannot be used.
    """
    _announced()
    return REGISTERED


def sensor_class(kind: str) -> type[Sensor]:
    """The sensor of that name."""
    return (REGISTERED if kind in REGISTERED else sensors())[kind]


def sensors_of(dataset: Dataset) -> tuple[Sensor, ...]:
    """Every sensor of a data set, with its rows."""
    return tuple(_sensor(dataset, one) for one in dataset.sensors)


def _sensor(dataset: Dataset, one: SensorData) -> Sensor:
    """A sensor of a data set: a camera that is a stripe scanner's has the scanner's parameters."""
    scanner = _scanner_of(dataset, one)
    return sensor_class(one.data.kind)(one.data) if scanner is None else ScannerCorners(seen_by(scanner, one.data))


def parts_with_lens(dataset: Dataset) -> tuple[Dataset, ...]:
    """The data of each sensor, with what is stated of its lens."""
    return tuple(replace(one.data, parameters=_stated_lens(dataset, one)) for one in dataset.sensors)


def is_of_scanner(part: Dataset) -> bool:
    """Whether the camera of a part, of `parts_with_lens`, is a stripe scanner's."""
    return part.parameters is NOT_THE_SCANNERS


def fitted_lens(part: Dataset) -> frozenset[str]:
    """Fitted lens parameters of a sensor beyond the first radial term: those that are not stated to be fixed."""
    fixed = {name for name, item in part.parameters.items() if item.fixed}
    return frozenset(part.format.lens) - fixed


def _stated_lens(dataset: Dataset, one: SensorData) -> dict[str, Parameter]:
    if _scanner_of(dataset, one) is not None:
        return NOT_THE_SCANNERS
    return {name.removeprefix(f"{one.camera}."): item for name, item in dataset.parameters.items()}


def _scanner_of(dataset: Dataset, one: SensorData) -> Dataset | None:
    """The stripe scanner of a camera; None for a separate camera."""
    return scanner_of(dataset.sensors, one) if one.data.kind == ScannerCorners.format.kind else None


@cache
def _announced() -> None:
    ours = [sensor.format.kind for sensor in (Stripe, CameraSensor, Point, Pose, Socket, Profile)]
    announced("robolaser.sensors", Sensor, taken=ours, name="", required=["format"])


__all__ = ["Sensor", "Stripe", "sensor_class", "sensors", "sensors_of"]
