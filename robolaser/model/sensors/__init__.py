"""Ways to measure, one file each."""

from robolaser.data.dataset import Dataset
from robolaser.model.sensors import formats as formats
from robolaser.model.sensors.point import Point
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.sensors.socket import Socket
from robolaser.model.sensors.stripe import Stripe

SENSORS: tuple[type[Sensor], ...] = (Stripe, Point, Socket)


def sensor_of(dataset: Dataset) -> Sensor:
    """The sensor that a data set was measured with."""
    return {kind.kind: kind for kind in SENSORS}[dataset.kind](dataset)


__all__ = ["SENSORS", "Point", "Sensor", "Socket", "Stripe", "sensor_of"]
