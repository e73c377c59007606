"""Pictures of a scene that is not there, and the truth behind every pixel of them.

For tests and demonstrations: what reads pictures must not know how they were drawn. `photograph` takes one.
"""

from robolaser.emulator.rendering.block import Block
from robolaser.emulator.rendering.camera import Eye
from robolaser.emulator.rendering.checkerboard import Checkerboard
from robolaser.emulator.rendering.floor import Floor
from robolaser.emulator.rendering.light import Sheet
from robolaser.emulator.rendering.photograph import Photograph, photograph
from robolaser.emulator.rendering.scene import Scene
from robolaser.emulator.rendering.solid import Solid
from robolaser.emulator.rendering.sphere import Sphere
from robolaser.emulator.rendering.truth import Stripe, Truth

__all__ = [
    "Block",
    "Checkerboard",
    "Eye",
    "Floor",
    "Photograph",
    "Scene",
    "Sheet",
    "Solid",
    "Sphere",
    "Stripe",
    "Truth",
    "photograph",
]
