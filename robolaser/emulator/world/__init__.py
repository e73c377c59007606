"""What is in an emulated cell, and where it truly is."""

from robolaser.emulator.world.world import EmulatedWorld
from robolaser.emulator.world.world_file import load_world

__all__ = ["EmulatedWorld", "load_world"]
