"""The model of a cell: the chain from encoder and image to points, with effects at its seams."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Scene, Suspect, bend_with
from robolaser.errors import NoPoints, NothingSeen
from robolaser.parameters import Parameters, Values
from robolaser.model.stages import Bend, Seam
from robolaser.model.sensors import Sensor, sensor_of

CHUNK = 400_000  # point-evaluations at a time: their residuals still fit into a processor's cache


@final
@dataclass(frozen=True)
class Model:
    """A data set seen through the nominal model and the effects added to it.

    Attributes:
        dataset: What was measured.
        suspects: Effects that are in the model; those at one seam act in this order.
    """

    dataset: Dataset
    suspects: tuple[Suspect, ...] = ()

    def __post_init__(self) -> None:
        if not len(self.dataset.points):
            folder = self.dataset.folder
            raise NothingSeen() if folder and (folder / "points.csv").exists() else NoPoints(folder)

    @cached_property
    def sensor(self) -> Sensor:
        """The way the data were measured."""
        return sensor_of(self.dataset)

    @cached_property
    def scene(self) -> Scene:
        """What effects may look at."""
        return Scene.of(self.dataset)

    def with_suspects(self, suspects: tuple[Suspect, ...]) -> "Model":
        """The same data seen with other effects; what was worked out about the data is kept."""
        other = Model(self.dataset, suspects)
        other.__dict__.update(sensor=self.sensor, scene=self.scene, _nominal_flange=self._nominal_flange)
        return other

    @cached_property
    def effect_parameters(self) -> Parameters:
        """The numbers of the effects."""
        return sum((suspect.parameters for suspect in self.suspects), start=Parameters(()))

    @cached_property
    def parameters(self) -> Parameters:
        """The sensor's parameters, then those of the effects."""
        nominal = {item.name: np.array([item.nominal]) for item in self.effect_parameters.items}
        bend = self.bend(nominal)
        return self.sensor.parameters(self.flange(nominal, bend), bend) + self.effect_parameters

    def bend(self, values: Values) -> Bend:
        """The effects with the numbers of each candidate."""
        return bend_with(tuple(suspect.at(values) for suspect in self.suspects), self.scene)

    @cached_property
    def _nominal_flange(self) -> Array:
        return self.dataset.flange()[None]

    @cached_property
    def _robot_bends(self) -> bool:
        return any(suspect.kind.seam in (Seam.JOINTS, Seam.LINKS) for suspect in self.suspects)

    def flange(self, values: Values, bend: Bend | None = None) -> Array:
        """T_base_flange at every pose, (c or 1, n, 4, 4)."""
        bend = bend or self.bend(values)
        poses, robot = self.dataset.poses, self.dataset.robot
        if not self._robot_bends or robot is None or poses.q is None:
            return bend(Seam.FLANGE, self._nominal_flange)
        q = bend(Seam.JOINTS, poses.q[None])
        return bend(Seam.FLANGE, robot.forward(q, bend(Seam.LINKS, robot.placements[None, None])))

    def _in_chunks(self, x: Array) -> Sequence[Array]:
        at_once = max(1, CHUNK // len(self.dataset.points))
        return np.array_split(x, max(1, -(-len(x) // at_once)))

    def residuals(self, x: Array) -> Array:
        """Known or measured points less predicted ones.

        Args:
            x: Candidates in the order of `parameters`, (c, d).

        Returns:
            (c, m, 3) [m]; not finite at the model's poles.
        """
        parts = [self.residuals_at(self.parameters.values(part)) for part in self._in_chunks(x)]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)

    def residuals_at(self, values: Values) -> Array:
        """The same for values by name, (c,) each, all candidates at once."""
        bend = self.bend(values)
        return self.sensor.residuals(values, self.flange(values, bend), bend)

    def completed(self, values: Values) -> Values:
        """Values with those parameters added that follow from the others in closed form."""
        bend = self.bend(values)
        return {**values, **self.sensor.follow(values, self.flange(values, bend), bend)}

    def with_gauge_held(self, x: Array) -> Array:
        """The same model, as far as any data can tell, with what the gauge holds at its nominal value, (d,)."""
        values = self.sensor.with_gauge_held(self.parameters.values(x[None]))
        return np.array([values[name][0] for name in self.parameters.names])

    def cost(self, x: Array) -> Array:
        """J of eq. 18, (c, d) -> (c,) [m²]; infinite at the model's poles."""
        if not self.suspects:
            return self.sensor.costs(x, self._nominal_flange)
        return np.concatenate([self._squares(self.parameters.values(part)) for part in self._in_chunks(x)])

    def _squares(self, values: Values) -> Array:
        bend = self.bend(values)
        return self.sensor.squares(values, self.flange(values, bend), bend)
