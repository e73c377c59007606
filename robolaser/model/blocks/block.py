"""Residual blocks: a sensor, what the problem calls its parameters, and its rows."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar, final

from robolaser.arrays import Array, Ints
from robolaser.model.sensors.sensor import Sensor
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values

T = TypeVar("T")


@final
@dataclass(frozen=True, eq=False)
class Block:
    """The rows that one sensor saw in one session."""

    sensor: Sensor  # as for a data set of these rows and all poses
    named: Mapping[str, str]  # the problem's name of each of its parameters
    rows: Ints  # which of the data set's rows it saw, (m,)
    of_rows: int  # how many rows the data set has
    name: str = ""  # of the sensor, where there are several
    session: str = ""  # where there are several
    scale: float = 1.0  # what a unit of its residuals counts for in the problem's

    @property
    def is_whole(self) -> bool:
        """Whether it has all rows."""
        return len(self.rows) == self.of_rows

    @property
    def numbers(self) -> int:
        """Of a row."""
        return self.sensor.format.numbers

    def values(self, values: Mapping[str, T]) -> dict[str, T]:
        """Those that the sensor has, by its own names."""
        return {own: values[whole] for own, whole in self.named.items() if whole in values}

    def of_problem(self, values: Mapping[str, T]) -> dict[str, T]:
        """The sensor's values by their names in the problem."""
        return {self.named[own]: value for own, value in values.items() if own in self.named}

    def perturbed(self, perturb: Perturbation) -> Perturbation:
        """The effects of the model for its rows."""
        return perturb if self.is_whole else perturb.of_rows(self.rows, self.of_rows)

    def at(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> tuple[Values, Array, Perturbation]:
        """What most functions of a sensor take: its values, the flange, the effects."""
        return self.values(values), T_base_flange, self.perturbed(perturb)

    def scaled(self, residuals: Array) -> Array:
        """The sensor's residuals in the problem's unit."""
        return residuals if self.scale == 1.0 else self.scale * residuals

    def unscaled(self, residuals: Array) -> Array:
        """The problem's residuals (..., its rows, k) as the sensor has them, (..., its rows, its numbers)."""
        own = residuals[..., : self.numbers]
        return own if self.scale == 1.0 else own / self.scale
