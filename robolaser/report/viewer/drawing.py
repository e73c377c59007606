"""Shapes as viser draws them."""

from typing import TYPE_CHECKING, Any

import numpy as np

from robolaser.report.viewer.shapes import Dots, Lines, Mesh, Shape

if TYPE_CHECKING:
    from viser import SceneApi


def draw(scene: "SceneApi", shape: Shape) -> Any:
    """Draw a shape, replacing any other of its name; returns viser's handle."""
    match shape:
        case Mesh():
            return scene.add_mesh_simple(
                shape.name,
                shape.vertices.astype(np.float32),
                shape.faces.astype(np.uint32),
                color=shape.colour,
                opacity=shape.opacity if shape.opacity < 1 else None,
                side="double",
                flat_shading=shape.opacity < 1,
                cast_shadow=shape.opacity == 1,
            )
        case Lines():
            return scene.add_line_segments(
                shape.name, shape.ends.astype(np.float32), shape.colours, thickness=shape.width_px,
                thickness_units="screen",
            )  # fmt: skip
        case Dots():
            return scene.add_point_cloud(
                shape.name, shape.positions.astype(np.float32), shape.colours, point_size=shape.size_m,
                point_shape="circle", precision="float32",
            )  # fmt: skip
