"""Searches and estimations that cannot begin or end."""

from collections.abc import Iterable

from robolaser.errors.base import RobolaserError, WrongUsage, near


class LossUnknown(WrongUsage):
    """No loss of that name."""

    def __init__(self, name: str, known: Iterable[str]) -> None:
        super().__init__(f"No loss '{name}'.{near(name, known)}")


class NothingFound(RobolaserError):
    """No candidate had a finite misfit."""

    def __init__(self) -> None:
        super().__init__(
            "No set of parameters within the bounds puts the points at finite places. "
            "Check the bounds in [parameters], stripe_axis and the units."
        )


class ResidualsShape(RobolaserError):
    """A residual function that does not return one row for each candidate."""

    def __init__(self, candidates: int, shape: tuple[int, ...]) -> None:
        super().__init__(
            f"The residuals of {candidates} candidates have shape {shape}, expected ({candidates}, k):"
            " one row of k residuals for each candidate, the same k in every call."
        )
