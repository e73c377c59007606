"""The simple shapes that a URDF draws of its links for collisions; meshes are never read."""

import xml.etree.ElementTree as ET

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import RobotError
from robolaser.geometry.urdf.parsing import numbers, origin_of, read_xml

SIZES = {"box": {"size": 3}, "sphere": {"radius": 1}, "cylinder": {"radius": 1, "length": 1}}
"""Attributes of each shape that state its size, and how many numbers each has."""
Shape = tuple[str, tuple[float, ...], Array]


def collision_shapes(text: str, *, source: str = "robot.urdf") -> dict[str, list[Shape]]:
    """Kind, size [m] and placement (4, 4) on its link of each box (x, y, z), sphere (radius) and cylinder.

    A cylinder's size is (radius, length), its axis z. Links with a mesh or with a shape whose size cannot be read are
    left out: their other shapes are but a part of them.

    Args:
        text: A URDF that was checked.
        source: What error messages call it.
    """
    found: dict[str, list[Shape]] = {}
    for link in read_xml(text, source).findall("link"):
        elements = link.findall("collision")
        try:
            shapes = [_shape(element, source) for element in elements]
        except RobotError:
            continue
        if shapes:
            found[link.get("name", "")] = shapes
    return found


def _shape(element: ET.Element, source: str) -> Shape:
    geometry = element.find("geometry/*")
    kind = "" if geometry is None else geometry.tag
    if geometry is None or kind not in SIZES:
        raise RobotError(f"{source}: <{kind}> is no simple shape.")
    size = np.concatenate([numbers(geometry.get(key), n, key, source) for key, n in SIZES[kind].items()])
    if (size <= 0).any():
        raise RobotError(f"{source}: a {kind} of no size.")
    return kind, tuple(size.tolist()), origin_of(element, "collision", source)
