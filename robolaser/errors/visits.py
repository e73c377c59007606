"""Poses that cannot be planned."""

from collections.abc import Sequence

from robolaser.errors.base import RobolaserError


class CannotPlan(RobolaserError):
    """A cell that says too little to plan poses in."""

    def __init__(self, lacking: str) -> None:
        super().__init__(f"Poses cannot be planned: {lacking}. Or give your own poses with --poses.")


class TargetPlaceUnknown(RobolaserError):
    """Nobody said where the target lies."""

    def __init__(self, missing: Sequence[str]) -> None:
        super().__init__(
            f"dataset.toml, [parameters] lacks {', '.join(missing)}: poses that see the target can only be planned"
            " where it is known to lie, to a few centimetres. State it with [target] placed = false, or give your own"
            " poses with --poses."
        )


class TooFewSights(RobolaserError):
    """An arm that sees the target from too few postures."""

    def __init__(self, robot: str, wanted: int, tried: int, seeing: int, allowed: int) -> None:
        limits = f", and {allowed} of these are allowed" if allowed < seeing else ""
        narrow = "widen [limits] in cell.toml if it may, take a smaller --run-up, " if 2 * allowed < seeing else ""
        super().__init__(
            f"{robot} sees the whole board and the stripe on it from {seeing} of {tried} postures that were"
            f" tried{limits}, but {wanted} are wanted. Ask for fewer poses, {narrow}move the board nearer to the middle"
            " of the arm's reach, or correct target.x ... in dataset.toml."
        )
