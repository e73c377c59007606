"""Robots described as text (URDF): read, checked and rewritten."""

from robolaser.geometry.urdf.collision_shapes import collision_shapes
from robolaser.geometry.urdf.parsing import MOST_JOINTS, load_text, parse
from robolaser.geometry.urdf.writing import minimal, with_fixed_frame, with_placements

__all__ = [
    "MOST_JOINTS",
    "collision_shapes",
    "load_text",
    "minimal",
    "parse",
    "with_fixed_frame",
    "with_placements",
]
