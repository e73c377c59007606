"""Sensors in a simulated cell, one file a kind.

To simulate a sensor of one's own, subclass `SimulatedSensor` with the `kind` of its format.
"""

from robolaser.simulation.sensors.camera import SimulatedCamera
from robolaser.simulation.sensors.point import SimulatedTracker
from robolaser.simulation.sensors.pose import SimulatedPoseTracker
from robolaser.simulation.sensors.profile import SimulatedProfile
from robolaser.simulation.sensors.simulated_sensor import REGISTERED, SimulatedSensor, impossible
from robolaser.simulation.sensors.socket import SimulatedSockets
from robolaser.simulation.sensors.stripe import SimulatedStripe


def simulated_sensor(kind: str) -> type[SimulatedSensor]:
    """The simulated sensor of that kind.

    Raises:
        UsageError: No sensor of that kind can be simulated.
    """
    if kind not in REGISTERED:
        raise impossible("sensor kind", kind, " or ".join(REGISTERED))
    return REGISTERED[kind]


__all__ = [
    "SimulatedCamera",
    "SimulatedPoseTracker",
    "SimulatedProfile",
    "SimulatedSensor",
    "SimulatedSockets",
    "SimulatedStripe",
    "SimulatedTracker",
    "simulated_sensor",
]
