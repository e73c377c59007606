"""A scanner's file that was asked for from a sensor without a camera."""

from robolaser.errors.base import RobolaserError


class NoCamera(RobolaserError):
    """A camera's file was asked for, from a sensor that has none."""

    def __init__(self, kind: str) -> None:
        super().__init__(f"A sensor of kind '{kind}' has no camera to describe; only 'stripe' has one.")
