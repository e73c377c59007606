"""What stands in an emulated cell, and where it truly is."""

from robolaser.emulator.world.reading import load_world
from robolaser.emulator.world.world import Sensor, World

__all__ = ["Sensor", "World", "load_world"]
