"""The parts of a data set that were measured in one session each."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Ints
from robolaser.data.dataset import Dataset
from robolaser.data.sessions import Sessions
from robolaser.model.sensors.sensor import Sensor


@final
@dataclass(frozen=True, eq=False)
class SessionPart:
    """One session: the rows that it has, and the sensor as it sees them, with all poses."""

    name: str
    rows: Ints
    sensor: Sensor

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of its parameters as they are without sessions."""
        return self.sensor.free + self.sensor.derived


def session_parts(dataset: Dataset, kind: type[Sensor], sessions: Sessions) -> Iterator[SessionPart]:
    """Each session that has points, with a sensor of that kind for its rows."""
    of_row = dataset.session_of_pose[dataset.points.pose]
    for number, name in enumerate(sessions.names):
        rows = np.flatnonzero(of_row == number)
        if len(rows):
            own = replace(dataset, points=dataset.points.take(rows), sessions=None)
            yield SessionPart(name, rows, kind(own))
