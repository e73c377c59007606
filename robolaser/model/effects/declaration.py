"""How an effect declares its parameters: amplitudes, which are zero when nominal, and nonlinear ones."""

from dataclasses import field
from typing import Any, NamedTuple


class Amplitude(NamedTuple):
    """A parameter of an effect that is zero when nominal."""

    name: str  # within the effect
    unit: str  # SI
    lower: float  # it is not below; zero where physics permits one sign only, else -bound
    bound: float  # it is not above
    # what is common in industry: fits, complexity penalties and detection limits are relative to it
    prior_scale: float


class Nonlinear(NamedTuple):
    """An inner parameter of an effect, such as a frequency: it has no meaning while all amplitudes are zero."""

    name: str
    unit: str
    lower: float
    upper: float
    nominal: float


def parameter(*, unit: str, bound: float, prior_scale: float, lower: float | None = None) -> Any:
    """Declare an amplitude, see `Amplitude`; it lies within ±bound where no lower bound is given."""
    return field(metadata={"amplitude": (unit, -bound if lower is None else lower, bound, prior_scale)})


def nonlinear(*, unit: str, lower: float, upper: float, nominal: float) -> Any:
    """Declare a nonlinear parameter, see `Nonlinear`.

    Within [lower, upper] the misfit may have many minima: `Effect.grid` says where to look.
    """
    return field(metadata={"nonlinear": (unit, lower, upper, nominal)})
