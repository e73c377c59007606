"""What the parameters of sensors and sessions are called in one problem: one name for one thing."""

from collections.abc import Mapping, Sequence

from robolaser.data.dataset import SensorData

THINGS = ("tool", "socket", "ball")
"""First parts of parameters that say where a named thing is: it is the same for all sensors."""
LASER = ("b", "theta")  # parameters of a scanner that are not its camera's


def names_in_problem(sensors: Sequence[SensorData], names: Sequence[Sequence[str]]) -> list[Mapping[str, str]]:
    """What each sensor's parameters are called in the problem.

    A target, a camera, a reflector, a socket or a ball that two sensors see has one set of parameters. Else a name that
    several sensors have begins with the sensor's, or with that of its camera or target: `left.base.x`.

    Args:
        sensors: One or more.
        names: Of the parameters of each by itself.

    Returns:
        The problem's names by the sensor's own.
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
    """What a parameter describes, the same text for the same thing."""
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
