"""How bright surfaces look, in the room's light and in the projector's."""

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.rendering.laser_sheet import LaserSheet
from robolaser.emulator.rendering.scene_view import Hits, SceneView
from robolaser.emulator.rendering.solid import Solid
from robolaser.emulator.rendering.vectors import dot, unit

LAMP = np.array([0.30, 0.20, 0.93]) / np.linalg.norm([0.30, 0.20, 0.93])
"""Where most of the room's light comes from, in the base frame."""
FROM_ALL_SIDES = 0.55
"""Share of the room's light that comes from everywhere."""
GLOSS = 80.0
"""Exponent of the lobe around a mirrored ray (Phong 1975): a glint some degrees wide."""
DARKEST_GREY = 0.02
"""Laser light below this is none."""


def of_the_room(view: SceneView, hits: Hits, breadth: float) -> Array:
    """Share of white paper's grey under the lamp, for what rays of some breadth [rad] met, (n,)."""
    share = np.zeros(len(hits.distance))
    for i, solid in enumerate(view.scene.solids):
        own = np.flatnonzero(hits.solid == i)
        normal, albedo = solid.plain() or _where_met(view, solid, hits.take(own), breadth)
        share[own] = albedo * (FROM_ALL_SIDES + (1.0 - FROM_ALL_SIDES) * np.maximum(normal @ LAMP, 0.0))
    return share


def of_the_laser(view: SceneView, sheet: LaserSheet, hits: Hits, breadth: float) -> Array:
    """Grey of what rays met in the projector's direct light, (n,)."""
    out = np.zeros(len(hits.distance))
    rows = np.flatnonzero(hits.solid >= 0)
    strength = sheet.grey(hits.seen[rows])
    rows, strength = rows[strength > DARKEST_GREY], strength[strength > DARKEST_GREY]
    own = hits.take(rows)
    out[rows] = strength * thrown(view, sheet, view.outside(own.seen), own, -own.ray @ view.turn.T, breadth)
    return out


def _where_met(view: SceneView, solid: Solid, hits: Hits, breadth: float) -> tuple[Array, Array]:
    """Normal and albedo of a solid where rays met it, (n, 3) and (n,)."""
    point = view.outside(hits.seen)
    return solid.normal(point), solid.albedo(point, view.place, breadth)


def thrown(view: SceneView, sheet: LaserSheet, point: Array, hits: Hits, towards: Array, breadth: float) -> Array:
    """Share of the projector's light that is thrown towards an eye: to all sides, and as a glint.

    Args:
        view: The scene before the camera.
        sheet: The projector.
        point: Where the light falls, in the base frame, (n, 3) [m].
        hits: The same places as the camera has them, (n).
        towards: Unit vectors to the eye, or to the mirror that shows it, (n, 3).
        breadth: Of the rays that met them [rad].
    """
    normal = view.scene.normals(point, hits.solid)
    source = view.outside(sheet.source)
    to_source = unit(source - point)
    cosine = np.maximum(dot(to_source, normal), 0.0)
    albedo = view.scene.albedo(point, hits.solid, view.place, breadth)
    shine = view.scene.shine[hits.solid]
    share = (1.0 - shine) * albedo * cosine
    glossy = shine > 0
    if glossy.any():
        mirror = 2.0 * dot(to_source, normal)[:, None] * normal - to_source
        lobe = np.maximum(dot(mirror, towards), 0.0) ** GLOSS
        share = share + shine * cosine * lobe
    reached = view.scene.reaches(point, normal, source)
    lit: Array = np.where(reached, share, 0.0)
    return lit
