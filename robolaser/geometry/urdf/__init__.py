"""Robots described as text (URDF): read, checked and rewritten."""

from robolaser.geometry.urdf.collision_shapes import collision_shapes
from robolaser.geometry.urdf.descriptions import SUFFIXES, DescriptionOptions, load_description
from robolaser.geometry.urdf.dh_table import DHStatement
from robolaser.geometry.urdf.parsing import MOST_JOINTS, load_text, parse
from robolaser.geometry.urdf.writing import minimal, with_fixed_frame, with_placements

__all__ = [
    "MOST_JOINTS",
    "SUFFIXES",
    "DHStatement",
    "DescriptionOptions",
    "collision_shapes",
    "load_description",
    "load_text",
    "minimal",
    "parse",
    "with_fixed_frame",
    "with_placements",
]
