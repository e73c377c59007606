"""Comparisons that cannot begin or go on, and contestants that break the rules."""

from robolaser.errors.base import RobolaserError


class CandidateNotANumber(RobolaserError):
    """A contestant asked for the cost of NaN."""

    def __init__(self, variable: str) -> None:
        super().__init__(f"It asked what a candidate costs whose {variable} is not a number.")


class CandidateShape(RobolaserError):
    """A contestant asked for the cost of something that is no array of candidates."""

    def __init__(self, shape: tuple[int, ...], dimension: int) -> None:
        super().__init__(
            f"It asked for costs with an array of shape {shape}, expected (candidates, {dimension}): a row each."
        )
