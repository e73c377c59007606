"""Rendered images of a scene, and the truth behind every pixel.

For tests and demonstrations: what reads pictures must not know how they were drawn. `photograph` takes one.
"""

from robolaser.emulator.rendering.camera import CameraModel
from robolaser.emulator.rendering.checkerboard import Checkerboard
from robolaser.emulator.rendering.cuboid import Cuboid
from robolaser.emulator.rendering.floor import Floor
from robolaser.emulator.rendering.laser_sheet import LaserSheet
from robolaser.emulator.rendering.photograph import Photograph, photograph
from robolaser.emulator.rendering.scene import EmulatedScene
from robolaser.emulator.rendering.solid import Solid
from robolaser.emulator.rendering.sphere import Ball
from robolaser.emulator.rendering.truth import StripeTruth, Truth

__all__ = [
    "Ball",
    "CameraModel",
    "Checkerboard",
    "Cuboid",
    "EmulatedScene",
    "Floor",
    "LaserSheet",
    "Photograph",
    "Solid",
    "StripeTruth",
    "Truth",
    "photograph",
]
