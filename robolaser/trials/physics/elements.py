"""What can be put into an arm that MuJoCo moves: springs between its bodies, soft drives, a load."""

from dataclasses import dataclass
from typing import Final, final

FOOT: Final = "(foot)"  # under the root link
BRACKET: Final = "(bracket)"  # between the flange and what it carries


@final
@dataclass(frozen=True)
class SpringHinge:
    """A hinge that no encoder sees."""

    # the joint before which it lies, whose frame it is given in before the joint turns; or `FOOT` or `BRACKET`, whose
    # frames are those of the base and of the flange
    before: str
    axis: tuple[float, float, float]  # (3,)
    at: tuple[float, float, float]  # a point on it, (3,) [m]
    stiffness: float  # [Nm/rad]


@final
@dataclass(frozen=True)
class Gear:
    """What drives a joint that does not stand where its encoder says."""

    stiffness: float  # of its spring, or the gain of its servo [Nm/rad or N/m]
    play: float = 0.0  # whole width of the range within which next to nothing holds it [rad or m]
    centring: float = 0.0  # stiffness within the play
    servo: bool = False  # whether a position servo of that gain holds it instead of a spring

    def torque(self, away: float) -> tuple[float, float]:
        """What a gear with play answers to a deflection [Nm or N], and the slope: little within it, a spring beyond."""
        within = min(max(away, -self.play / 2), self.play / 2)
        slope = self.centring if within == away else self.stiffness
        return -self.centring * within - self.stiffness * (away - within), -slope


@final
@dataclass(frozen=True)
class Load:
    """What the bracket carries: its mass [kg], and where that is in the flange's frame, (3,) [m]."""

    mass: float
    at: tuple[float, float, float]
