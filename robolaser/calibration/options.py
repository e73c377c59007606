"""How to calibrate: what may be chosen."""

from dataclasses import dataclass
from typing import final

GENERATIONS = 500  # then the polish of every member of the last generation ends in the same optimum


@final
@dataclass(frozen=True)
class Plan:
    """How to calibrate.

    Attributes:
        algorithm: Name of the global search; by default `screening` for a stripe scanner and none (`gauss-newton`)
            for trackers and sockets, whose parameters start from a closed form.
        polish: Whether Gauss-Newton steps follow the search.
        weights: "plain" minimises J as it stands; "noise" weighs residuals by the covariance of their noise.
        loss: "square"; "huber" and "cauchy" let gross errors count for less, by a scale from the residuals.
        effects: `EFFECT[:WHERE]` each.
        seed: Of the search.
        generations: Of a search that has any.
    """

    algorithm: str | None = None
    polish: bool = True
    weights: str = "plain"
    loss: str = "square"
    effects: tuple[str, ...] = ()
    seed: int = 1
    generations: int = GENERATIONS
