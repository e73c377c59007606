"""Ways to measure, one file each.

A sensor of one's own is a subclass of `Sensor`, defined anywhere before a data set of its kind is read; or an installed
package announces it by an entry point in the group `robolaser.sensors`.
"""

from functools import cache

from robolaser.data.dataset import Dataset
from robolaser.model.sensors.camera import Camera
from robolaser.model.sensors.per_session import PerSession
from robolaser.model.sensors.point import Point
from robolaser.model.sensors.pose import Pose
from robolaser.model.sensors.profile import Profile
from robolaser.model.sensors.sensor import REGISTERED, Sensor
from robolaser.model.sensors.socket import Socket
from robolaser.model.sensors.stripe import Stripe
from robolaser.plugins import announced


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


def sensor_of(dataset: Dataset) -> Sensor:
    """The sensor that a data set was measured with."""
    kind = sensor_class(dataset.kind)
    return kind(dataset) if dataset.sessions is None else PerSession(dataset, kind, dataset.sessions)


@cache
def _announced() -> None:
    ours = [sensor.format.kind for sensor in (Stripe, Camera, Point, Pose, Socket, Profile)]
    announced("robolaser.sensors", Sensor, taken=ours, name="", required=["format"])


__all__ = ["Camera", "Point", "Pose", "Profile", "Sensor", "Socket", "Stripe", "sensor_class", "sensor_of", "sensors"]
