"""The parameters of a sensor: those that must be given, that follow from the data, and that no data can determine."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array
from robolaser.data.sensor_format import SensorFormat
from robolaser.errors import DataError
from robolaser.model.stages import Perturbation
from robolaser.parameters import Parameter, Values


@final
@dataclass(frozen=True)
class SensorParameters:
    """Names of the parameters, and prior knowledge of them.

    Attributes:
        free: Parameters whose nominal values and bounds the data set gives; none where all follow from the data.
        derived: Parameters that `initialize` finds from the others; the data set may leave them out.
        fixed: Those that stay at their nominal values because the model has a freedom that no data can fix.
        fix_gauge: Converts values (c,) by name to those of an equivalent model for any data, with the fixed parameters
            at their nominal values.
        closed_form: Source from which `initialize` finds missing free parameters: "the board's corners"; "" where the
            data set must give them.
        spans: How far parameters may be from their closed-form start values, by name, from all values; others a metre
            or half a turn.
        two_axes: Whether the flange must turn about two axes for any fit to find them: unknown placements at both ends
            of the arm, A X = Z B.
        linear: Free parameters that `solve` finds from the other free ones: searches need only the latter.
        solve: From all values, T_base_flange (c or 1, n, 4, 4), the effects of the model and all parameters by name to
            the linear and the derived parameters that fit best with the others, (c,) each; the model is linearized
            where the values have them.
    """

    free: tuple[str, ...] = ()
    derived: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    fix_gauge: Callable[[Values], Values] = lambda values: values
    closed_form: str = ""
    spans: Callable[[Mapping[str, float]], Mapping[str, float]] = lambda values: {}
    two_axes: bool = False
    linear: tuple[str, ...] = ()
    solve: Callable[[Values, Array, Perturbation, Mapping[str, Parameter]], Values] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """All of them."""
        return self.free + self.derived


def not_given(sensor: SensorFormat, missing: Sequence[str], otherwise: str = "") -> DataError:
    """The error of missing free parameters, and what to do otherwise."""
    return DataError(
        f"dataset.toml, [parameters] lacks {', '.join(missing)}: a {sensor.kind} sensor needs "
        f"{{ nominal, lower, upper }} for each.{otherwise}",
        file="dataset.toml",
        column="[parameters]",
    )
