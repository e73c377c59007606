"""The plan of a calibration: its options with their defaults."""

from dataclasses import dataclass
from typing import Any, final

from robolaser.errors import UsageError, check_seed, near
from robolaser.model.effects.effect import Effect

GENERATIONS = 500  # after these generations, local refinement of any member ends in the same optimum


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
        effects: Names, as `EFFECT[:WHERE]`, or classes; or one of these.
        seed: Seed of the search.
        generations: Number of generations, for searches that have any.

    Raises:
        UsageError: The weights are unknown or would not be used, there are no generations, or the seed is negative.

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
        given: Any = self.effects
        if isinstance(given, str | type):
            object.__setattr__(self, "effects", (given,))
        check_seed(self.seed)
        if self.weights not in WEIGHTS:
            raise UsageError(f"No weights '{self.weights}'.{near(self.weights, WEIGHTS)}")
        if self.weights != "plain" and not self.polish:
            raise UsageError(
                "Weights act in the local refinement, which `polish` omits here: leave out one of the two."
            )
        if self.generations < 1:
            raise UsageError(f"A search has 1 generation or more, not {self.generations}.")
