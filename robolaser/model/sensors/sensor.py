"""What a way to measure is: its parameters, and what is left between measured and predicted points."""

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset
from robolaser.data.toml_schema import unit_of
from robolaser.errors import ParameterMissing, ParameterUnknown
from robolaser.geometry.rigid_motion import from_angles, pose, to_angles
from robolaser.model.stages import Perturbation
from robolaser.parameters import Parameter, Parameters, Values

LENGTH_SPAN_M = 1.0  # closed forms miss by centimetres; an arm's reach bounds the search generously
ANGLE_SPAN_RAD = np.pi
SIX = ("x", "y", "z", "w", "phi", "psi")


class Sensor(ABC):
    """A way to measure, for one data set. A subclass is one kind of `[sensor]`."""

    kind: ClassVar[str]

    def __init__(self, dataset: Dataset) -> None:
        self.dataset = dataset

    @property
    @abstractmethod
    def own(self) -> tuple[str, ...]:
        """Parameters whose nominal values and bounds the data set must give."""

    @property
    @abstractmethod
    def following(self) -> tuple[str, ...]:
        """Parameters that follow from the others in closed form; the data set may leave them out."""

    @property
    def apart(self) -> tuple[tuple[tuple[str, ...], Ints], ...]:
        """Groups of parameters of which no row depends on more than one: their names, and which is each row's, (m,)."""
        return ()

    @property
    def held(self) -> tuple[str, ...]:
        """Parameters that stay at their nominal values because the model has a freedom that no data can fix."""
        return ()

    def fix_gauge(self, values: Values) -> Values:
        """The same model, as far as any data can tell, with the held parameters at their nominal values."""
        return values

    @abstractmethod
    def follow(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Values:
        """The following parameters that fit best, for each candidate, as (c,) by name.

        Args:
            values: The own parameters.
            T_base_flange: (c or 1, n, 4, 4).
            perturb: The effects of the model.
        """

    @property
    def eliminated(self) -> tuple[str, ...]:
        """Parameters that `complete` finds: a search need not look for them."""
        return self.following

    @abstractmethod
    def complete(self, values: Values, T_base_flange: Array, perturb: Perturbation, bounds: Parameters) -> Values:
        """The eliminated parameters that fit best within their bounds, for each candidate, as (c,) by name.

        Args:
            values: All others. Eliminated ones among them say where to take effects that depend on them.
            T_base_flange: (c or 1, n, 4, 4).
            perturb: The effects of the model.
            bounds: Has the eliminated parameters; candidates at a pole get their nominal values.
        """

    @abstractmethod
    def residuals(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """Known or measured point less predicted point, (c, m, 3) [m]; not finite at the model's poles."""

    def squares(self, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
        """J of eq. 18, the sum of squared residuals, (c,) [m²]; infinite at the model's poles."""
        return sum_of_squares(self.residuals(values, T_base_flange, perturb))

    def costs(self, x: Array, T_base_flange: Array) -> Array:
        """The same for the unbent model and candidates in the order of `own`, then `following`, (c, d) -> (c,)."""
        names = self.own + self.following
        return self.squares(dict(zip(names, x.T, strict=True)), T_base_flange, Perturbation())

    @property
    def held_out_groups(self) -> Ints | None:
        """Group of each row, (m,), where cross-validation leaves out more than poses together; None: whole poses."""
        return None

    def located_apart(self, errors: Array) -> Array:
        """Errors of held-out rows (m, k) once what only they can locate is located from them."""
        return errors

    def parameters(self, T_base_flange: Array, perturb: Perturbation) -> Parameters:
        """All parameters: as given, and where nothing is given from the closed form at the nominal values.

        Raises:
            ParameterUnknown: The data set gives one that this sensor does not have.
            ParameterMissing: It does not give all of this sensor's own.
        """
        given = self.dataset.parameters
        for name in given:
            if name not in self.own + self.following:
                raise ParameterUnknown(name, self.own + self.following)
        missing = [name for name in self.own if name not in given]
        if missing:
            raise ParameterMissing(missing, self.kind)
        items = [given[name] for name in self.own]
        if self.following:
            nominal = {item.name: np.array([item.nominal]) for item in items}
            closed = self.follow(nominal, T_base_flange, perturb)
            for name in self.following:
                span = ANGLE_SPAN_RAD if unit_of(name) == "rad" else LENGTH_SPAN_M
                at = float(closed[name][0])
                start = Parameter(name, unit_of(name), at, at - span, at + span, given=False)
                items.append(given.get(name, start))
        return Parameters(tuple(items))


def motion(values: Values, prefix: str) -> Array:
    """The rigid motion of six parameters `prefix.x` .. `prefix.psi`, (c, 4, 4)."""
    x, y, z, w, phi, psi = (values[f"{prefix}.{part}"] for part in SIX)
    return pose(from_angles(w, phi, psi), np.stack([x, y, z], axis=-1))


def six_of(T: Array, prefix: str) -> dict[str, Array]:
    """The six parameters of a rigid motion (c, 4, 4), by name."""
    parts = (*np.moveaxis(T[:, :3, 3], -1, 0), *to_angles(T[:, :3, :3]))
    return {f"{prefix}.{part}": value for part, value in zip(SIX, parts, strict=True)}


def vector(values: Values, prefix: str) -> Array:
    """The point of three parameters `prefix.x` .. `prefix.z`, (c, 3)."""
    return np.stack([values[f"{prefix}.{part}"] for part in "xyz"], axis=-1)


def sum_of_squares(residuals: Array) -> Array:
    """Of residuals (c, ...) -> (c,); infinite where one of them is not finite."""
    flat = residuals.reshape(len(residuals), -1)
    with np.errstate(over="ignore", invalid="ignore"):
        J = np.einsum("ij,ij->i", flat, flat)
    return np.where(np.isfinite(J), J, np.inf)
