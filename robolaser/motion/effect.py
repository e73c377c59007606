"""An effect on a moving arm: numbers that its model has in addition to those of an ideal arm."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, final

import numpy as np

from robolaser.arrays import Array
from robolaser.estimation.certainty import EVEN
from robolaser.motion.gap import root_mean_squares

if TYPE_CHECKING:
    from robolaser.motion.quantities import Quantities

TIMING, TOOL, JOINTS = "timing", "tool", "joints"
UNKNOWN = "unknown"  # the cause of functions of unknown form
OF_ANGLE, OF_LOAD = "function_of_angle", "function_of_load"  # names of these functions

MOVES_RAD = 1e-3  # least spread of the commands of a moving joint. A judgement
RowKind = Literal["tracking", "torque", "load"]
"""Kinds of rows: readings against commands, torques against inverse dynamics, one encoder against the other."""


@final
@dataclass(frozen=True)
class Number:
    """A number of an effect."""

    name: str
    unit: str
    usual: float  # usual size: the scale of errors of numbers and of first steps
    lower: float = float("-inf")
    upper: float = float("inf")
    servo: str = ""  # its name in the servo's model; "": it is a factor of a column
    least: float = 0.0  # in size; smaller ones imitate other effects and are not reported


@final
@dataclass(frozen=True, eq=False)
class Trace:
    """A joint that follows commands: commanded and measured angles."""

    command: Array  # (n, runs) [rad]
    q: Array  # (n, runs) [rad]; NaN where it was not read
    holding: Array  # gravity torque at the commanded position, (n, runs) [Nm]
    moving: Array  # torque of the rigid arm along the commands, (n, runs) [Nm]
    step_s: Array  # from row to row, (n, runs) [s]

    @property
    def error_within(self) -> float:
        """RMS error at commands within the range of all readings [rad]; infinite if there are none."""
        within = (self.command >= np.nanmin(self.q)) & (self.command <= np.nanmax(self.q))
        return float(np.nan_to_num(root_mean_squares((self.q - self.command)[within]), nan=np.inf))

    @property
    def is_sent(self) -> bool:
        """Whether it is commanded to move."""
        return bool(np.nanstd(self.command) >= MOVES_RAD)

    @property
    def stuck(self) -> str:
        """Reason why a joint cannot be tested: it is commanded to move, but stands still or moves the other way."""
        if self.is_sent and np.nanstd(self.q) < MOVES_RAD:
            return "the joint does not move, though it is commanded to"
        sent = self.command - np.nanmean(self.command)
        way = np.nansum(sent * self.q) / max(float(np.nansum(sent**2)), 1e-12)
        return "the joint moves opposite to its commands" if self.is_sent and way < -EVEN else ""


def if_sent(trace: Trace) -> str:
    """Reason why an effect cannot be tested on a joint: it has to be commanded to move."""
    return "" if trace.is_sent else "the joint was not commanded to move"


def at_size(numbers: tuple["Number", ...], trace: Trace, size: float, spread: float) -> list[float]:
    """Start of a fit: each number so many times its usual size, with a sign that its bounds allow; else zero."""
    return [size if each.lower >= 0.0 else -size if each.upper <= 0.0 else 0.0 for each in numbers]


@final
@dataclass(frozen=True)
class MotionEffect:
    """One effect: an entry in one of the files of `effects`."""

    name: str
    clause: str  # continues "The gap is explained:"
    cause: str  # its class
    rows: RowKind
    numbers: tuple[Number, ...]
    remedy: str
    reference: str
    form: str = ""  # where a name has several forms; the simplest has none
    site: str = "joint"
    rivals: tuple[str, ...] = ()  # effects that many motions cannot distinguish from it
    imitated_by: tuple[str, ...] = ()  # functions of unknown form that may replace it at its joint
    rarity: float = 0.0  # twice the logarithm of how much rarer it is than the others
    # Of rows that are linear in its numbers: columns for some shapes of it, each (n, j, numbers), n rows of j joints.
    columns: Callable[["Quantities", int], Sequence[Array]] | None = None
    # What differs between its shapes: a name, its unit, and the value of each.
    shape: Callable[["Quantities", int], tuple[str, str, Sequence[float]]] | None = None
    # How large its numbers can be at all, (numbers,): one standard deviation before any row is seen.
    sizes: Callable[["Quantities", int], Array] | None = None
    # The least that its numbers can be, (numbers,), where that depends on the arm: no link has a negative mass.
    least: Callable[["Quantities", int], Array] | None = None
    needs: Callable[["Quantities", int], str] | None = None  # why it cannot be tested at a joint; "" where it can
    # The same for rows that follow commands; and the start of its numbers, in usual sizes, by a size and the residual.
    untested: Callable[[Trace], str] = if_sent
    begins: Callable[[tuple[Number, ...], Trace, float, float], list[float]] = at_size


@final
@dataclass(frozen=True)
class At:
    """An effect at a location."""

    effect: MotionEffect
    where: str
    joint: int  # column of the joint; 0 where the effect is at no joint

    def __str__(self) -> str:
        form = f" ({self.effect.form})" if self.effect.form else ""
        return f"{self.effect.name}{form} at {self.where}"

    @property
    def pair(self) -> list[str]:
        """Its name in JSON files."""
        return [self.effect.name, self.where]
