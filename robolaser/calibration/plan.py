"""The plan of a calibration: its options with their defaults."""

from dataclasses import dataclass
from typing import final

from robolaser.errors import UsageError, near
from robolaser.model.effects.effect import Effect

GENERATIONS = 500
"""After these generations, local refinement of any member ends in the same optimum."""


WEIGHTS = ("plain", "noise")


@final
@dataclass(frozen=True)
class Plan:
    """The options of a calibration.

    Attributes:
        algorithm: Name of the global search; default: `screening` for a stripe scanner and none (`gauss-newton`)
            for trackers and sockets, whose parameters start from a closed form.
        polish: Whether local refinement follows the search.
        weights: "plain" minimises J; "noise" weights residuals by the covariance of their noise.
        effects: Names, as `EFFECT[:WHERE]`, or classes.
        seed: Seed of the search.
        generations: Number of generations, for searches that have any.

    Raises:
        UsageError: The weights are unknown.

    Examples:
        >>> robolaser.Plan(effects=("laser_roll",)).weights
        'plain'
    """

    algorithm: str | None = None
    polish: bool = True
    weights: str = "plain"
    effects: tuple[str | type[Effect], ...] = ()
    seed: int = 1
    generations: int = GENERATIONS

    def __post_init__(self) -> None:
        if self.weights not in WEIGHTS:
            raise UsageError(f"No weights '{self.weights}'.{near(self.weights, WEIGHTS)}")
