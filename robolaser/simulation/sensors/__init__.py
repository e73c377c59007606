"""Sensors in a simulated cell, one file a kind.

To simulate a custom sensor, subclass `SimulatedSensor` with the `kind` of its format.
"""

from robolaser.simulation.sensors import camera, point, pose, profile, socket, stripe  # noqa: F401 - each enters itself
from robolaser.simulation.sensors.simulated_sensor import REGISTERED, SimulatedSensor, impossible


def simulated_sensor(kind: str) -> type[SimulatedSensor]:
    """The simulated sensor of that kind; a `UsageError` if there is none."""
    if kind not in REGISTERED:
        raise impossible("sensor kind", kind, " or ".join(REGISTERED))
    return REGISTERED[kind]
