"""Second lines: what shiny surfaces show of the stripe, and where they throw it."""

import numpy as np

from robolaser.arrays import Array
from robolaser.emulator.rendering.laser_sheet import LaserSheet
from robolaser.emulator.rendering.scene import AWAY_M
from robolaser.emulator.rendering.scene_view import Hits, SceneView
from robolaser.emulator.rendering.shading import DARKEST_GREY, thrown
from robolaser.emulator.rendering.solid import Face
from robolaser.emulator.rendering.vectors import dot, unit


def reflected_lines(view: SceneView, sheet: LaserSheet, hits: Hits, breadth: float) -> Array:
    """Grey of the projector's light that comes by a mirror, for what rays of some breadth [rad] met, (n,)."""
    return shown(view, sheet, hits, breadth) + cast_back(view, sheet, hits, breadth)


def shown(view: SceneView, sheet: LaserSheet, hits: Hits, breadth: float) -> Array:
    """Grey of stripes elsewhere that shiny surfaces show, (n,)."""
    out = np.zeros(len(hits.distance))
    shine = view.scene.shine
    rows = np.flatnonzero((hits.solid >= 0) & (shine[hits.solid] > 0))
    if len(rows) == 0:
        return out
    own = hits.take(rows)
    point, direction = view.outside(own.seen), own.ray @ view.turn.T
    normal = view.scene.normals(point, own.solid)
    direction = direction - 2.0 * dot(direction, normal)[:, None] * normal
    distance, solid = view.scene.cast(point + AWAY_M * normal, direction)
    met = np.flatnonzero(solid >= 0)
    there = point[met] + direction[met] * distance[met, None]
    inside = (there - view.place) @ view.turn
    strength = sheet.grey(inside)
    bright = np.flatnonzero(strength > DARKEST_GREY)
    far = np.sqrt(dot(inside[bright], inside[bright]))
    second = Hits(inside[bright] / far[:, None], far, solid[met][bright])
    light = strength[bright] * thrown(view, sheet, there[bright], second, -direction[met][bright], breadth)
    out[rows[met[bright]]] = shine[own.solid[met[bright]]] * light
    return out


def cast_back(view: SceneView, sheet: LaserSheet, hits: Hits, breadth: float) -> Array:
    """Grey of the light that shiny faces throw from the projector onto other surfaces, (n,)."""
    out = np.zeros(len(hits.distance))
    for i, solid in enumerate(view.scene.solids):
        if solid.shine > 0:
            rows = np.flatnonzero((hits.solid >= 0) & (hits.solid != i))
            for face in solid.faces():
                out[rows] += solid.shine * _cast_back_by(face, view, sheet, hits.take(rows), breadth)
    return out


def _cast_back_by(face: Face, view: SceneView, sheet: LaserSheet, hits: Hits, breadth: float) -> Array:
    out = np.zeros(len(hits.distance))
    point, source = view.outside(hits.seen), view.outside(sheet.source)
    height, height_of_source = (point - face.middle) @ face.normal, float((source - face.middle) @ face.normal)
    if height_of_source <= 0:
        return out
    image = point - 2.0 * height[:, None] * face.normal
    strength = np.where(height > AWAY_M, sheet.grey((image - view.place) @ view.turn), 0.0)
    rows = np.flatnonzero(strength > DARKEST_GREY)
    if len(rows) == 0:
        return out
    point, height = point[rows], height[rows]
    share = height / (height + height_of_source)
    mirrored_source = source - 2.0 * height_of_source * face.normal
    crossing = point + share[:, None] * (mirrored_source - point)
    on = (np.abs((crossing - face.middle) @ face.axes.T) <= face.half).all(axis=1)
    on &= view.scene.reaches(crossing, np.broadcast_to(face.normal, crossing.shape), source)
    solid = hits.solid[rows]
    normal = view.scene.normals(point, solid)
    on &= view.scene.reaches(point, normal, crossing)
    cosine = np.maximum(dot(unit(crossing - point), normal), 0.0)
    albedo = (1.0 - view.scene.shine[solid]) * view.scene.albedo(point, solid, view.place, breadth)
    out[rows] = np.where(on, strength[rows] * albedo * cosine, 0.0)
    return out
