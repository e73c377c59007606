"""What stands in an emulated cell, and where it truly is."""

from robolaser.emulator.world.reading import load_world
from robolaser.emulator.world.world import EmulatedWorld, ImageSensor

__all__ = ["EmulatedWorld", "ImageSensor", "load_world"]
