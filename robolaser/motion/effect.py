"""What an effect on a moving arm is: numbers that a model of its rows has beside those of an ideal arm."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, final

from robolaser.arrays import Array

if TYPE_CHECKING:
    from robolaser.motion.quantities import Quantities

TIMING, TOOL = "timing", "tool"

Kind = Literal["tracking", "torque", "load"]
"""Of rows: measured against commands, torques against inverse dynamics, one encoder against the other."""


@final
@dataclass(frozen=True)
class Number:
    """A number of an effect."""

    name: str
    unit: str
    usual: float  # size that is usual; errors of numbers and first steps are judged by it
    lower: float = float("-inf")
    upper: float = float("inf")
    servo: str = ""  # its name in the servo's model; "": it is a factor of a column
    ideal: float = 0.0  # where it does nothing
    least: float = 0.0  # in size; smaller ones are the forms of other effects, and are not named


@final
@dataclass(frozen=True)
class MotionEffect:
    """One effect: an entry in one of the files beside this one."""

    name: str
    title: str
    clause: str  # goes on from "The gap is explained:"
    cause: str  # its class
    rows: Kind
    numbers: tuple[Number, ...]
    remedy: str
    reference: str
    form: str = ""  # of several that one name has; the simplest has none
    site: str = "joint"
    rivals: tuple[str, ...] = ()  # effects that many motions cannot tell from it
    rarity: float = 0.0  # twice the logarithm of how much rarer it is than the others
    # Of rows that are linear in its numbers: columns for some shapes of it, each (n, j, numbers), n rows of j joints.
    columns: Callable[["Quantities", int], Sequence[Array]] | None = None
    # How large its numbers can be at all, (numbers,): one standard deviation before any row is seen.
    sizes: Callable[["Quantities", int], Array] | None = None
    needs: Callable[["Quantities", int], str] | None = None  # why it cannot be tested at a joint; "" where it can


@final
@dataclass(frozen=True)
class At:
    """An effect at a place."""

    effect: MotionEffect
    where: str
    joint: int  # column of the joint; the first for what sits at no joint

    def __str__(self) -> str:
        form = f" ({self.effect.form})" if self.effect.form else ""
        return f"{self.effect.name}{form} at {self.where}"

    @property
    def pair(self) -> list[str]:
        """As JSON files name it."""
        return [self.effect.name, self.where]
