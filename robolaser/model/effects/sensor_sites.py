"""Sites of effects that each of several sensors has for itself: `left.laser`, `right.laser`."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Bools
from robolaser.data.dataset import Dataset, SensorData

OWNER: dict[str, Callable[[SensorData], str]] = {
    "laser": lambda sensor: sensor.name,
    "measuring_system": lambda sensor: sensor.name,
    "camera": lambda sensor: sensor.camera,
    "target": lambda sensor: sensor.target,
}
"""The prefix of such a site's name: sensors with a common camera or target share the site."""


def kind_of_site(where: str) -> str:
    """The site without a sensor's name: `laser` of `left.laser`; a joint's name as it is."""
    site = where.rpartition(".")[2]
    return site if site in OWNER else where


def of_sensor(where: str) -> bool:
    """Whether a site belongs to some sensors only."""
    return kind_of_site(where) != where


def sensors_at(where: str, dataset: Dataset) -> Bools:
    """Which sensors are at such a site, (sensors,)."""
    name, _, site = where.rpartition(".")
    return np.array([OWNER[site](sensor) == name for sensor in dataset.sensors])


def sites_of_sensors(site: str, dataset: Dataset, has: Callable[[int], bool]) -> dict[str, Bools]:
    """Names of a site such as `laser`, and which sensors are there, (sensors,); itself if all share it.

    `has` is whether the sensor of a number has the site.
    """
    sensors, owner = dataset.sensors, OWNER.get(site)
    there = np.array([has(number) for number in range(len(sensors))])
    owners = np.array(["" if owner is None else owner(sensor) for sensor in sensors])
    names = dict.fromkeys(owners[there].tolist())
    if len(names) < 2:
        return {site: np.ones(len(there), dtype=bool)}
    return {f"{name}.{site}": there & (owners == name) for name in names}
