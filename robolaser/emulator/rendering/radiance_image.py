"""The light that falls on the sensor, before the sensor adds what is its own."""

from dataclasses import dataclass
from typing import final

import cv2
import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.emulator.rendering import shading
from robolaser.emulator.rendering.inter_reflections import reflected_lines
from robolaser.emulator.rendering.laser_sheet import LaserSheet
from robolaser.emulator.rendering.scene_view import Hits, SceneView
from robolaser.emulator.rendering.vectors import unit

FINE = 2  # rays a pixel, along u and along v, where something changes within it
REACH = 4.5  # standard deviations of the sheet, beyond which it is dark
SLOPE = (0.25, -0.15)  # of the room's light, from one side of the image to the other, along u and v
COARSE = 4  # pixels between the rays that look for second lines


@final
@dataclass(frozen=True, eq=False)
class RadianceImage:
    """Light without chance.

    Attributes:
        view: The scene before the eye.
        sheet: The projector.
        lit: Whether it was on.
        room: Light of the room, 1 for white paper under the lamp, (height, width).
        laser: Light of the projector [grey], (height, width).
    """

    view: SceneView
    sheet: LaserSheet
    lit: bool
    room: Array
    laser: Array


def render_radiance(
    view: SceneView, sheet: LaserSheet, *, lit: bool, reflections: bool = True, blur_px: float = 0.6
) -> RadianceImage:
    """Gather the light of every pixel, with more rays where something changes within one.

    Args:
        view: The scene before the eye.
        sheet: The projector, in the camera frame.
        lit: Whether it is on.
        reflections: Whether shiny solids show the stripe on others, and throw it there.
        blur_px: Standard deviation of the lens's blur [px].
    """
    breadth = view.eye.pixel_rad
    room = shading.of_the_room(view, view.all, breadth)
    laser = np.zeros(len(room))
    edges = _outlines(view)
    room[edges] = _of_pixels(shading.of_the_room(view, _finely(view, edges), breadth / FINE))
    if lit:
        rows = _near_the_sheet(view, sheet)
        mirrors = reflections and bool((view.scene.shine > 0).any())
        if mirrors:
            rows = np.union1d(rows, _near_reflected_lines(view, sheet))
        fine = _finely(view, rows)
        light = shading.of_the_laser(view, sheet, fine, breadth / FINE)
        if mirrors:
            light += reflected_lines(view, sheet, fine, breadth / FINE)
        laser[rows] = _of_pixels(light)
    shape = view.eye.height_px, view.eye.width_px
    falling = room.reshape(shape) * _falling_off(shape)
    return RadianceImage(view, sheet, lit, _blurred(falling, blur_px), _blurred(laser.reshape(shape), blur_px))


def _of_pixels(light: Array) -> Array:
    """Mean over the rays of each pixel."""
    mean: Array = light.reshape(-1, FINE * FINE).mean(axis=1)
    return mean


def _outlines(view: SceneView) -> Ints:
    """Pixels beside which another solid shows."""
    solid = view.all.solid.reshape(view.eye.height_px, view.eye.width_px)
    rim = np.zeros(solid.shape, dtype=np.bool_)
    for axis in (0, 1):
        changes = np.diff(solid, axis=axis) != 0
        ahead = [slice(None), slice(None)]
        behind = [slice(None), slice(None)]
        ahead[axis], behind[axis] = slice(1, None), slice(None, -1)
        rim[tuple(ahead)] |= changes
        rim[tuple(behind)] |= changes
    return np.flatnonzero(rim)


def _near_the_sheet(view: SceneView, sheet: LaserSheet) -> Ints:
    """Pixels that the stripe may reach."""
    distance = view.all.distance
    with np.errstate(invalid="ignore"):
        off = distance * (view.all.ray @ sheet.normal) - sheet.source @ sheet.normal
        reach = REACH * sheet.width_m + distance * (view.eye.pixel_rad + abs(np.tan(sheet.curvature)))
        return np.flatnonzero(np.abs(off) < reach)


def _near_reflected_lines(view: SceneView, sheet: LaserSheet) -> Ints:
    """Pixels around what a coarse grid of rays finds by mirrors."""
    shape = view.eye.height_px, view.eye.width_px
    rows = np.arange(shape[0] * shape[1]).reshape(shape)[::COARSE, ::COARSE].ravel()
    found = np.zeros(shape, dtype=np.uint8)
    found.ravel()[rows] = reflected_lines(view, sheet, view.all.take(rows), view.eye.pixel_rad) > 0
    return np.flatnonzero(cv2.dilate(found, np.ones((2 * COARSE + 3, 2 * COARSE + 3), np.uint8)))


def _finely(view: SceneView, rows: Ints) -> Hits:
    """What rays through the parts of pixels meet, part by part, (n * FINE²)."""
    part = (np.arange(FINE) + 0.5) / FINE - 0.5
    right, down = (grid.ravel()[:, None] for grid in np.meshgrid(part, part))
    along_u, along_v = (slope.reshape(-1, 3)[rows, None] for slope in view.eye.slopes)
    ray = view.all.ray[rows, None] + right * along_u + down * along_v
    return view.along(unit(ray.reshape(-1, 3)))


def _falling_off(shape: tuple[int, int]) -> Array:
    """The room's light over the image: brighter on one side, (height, width)."""
    v, u = (np.linspace(-0.5, 0.5, length) for length in shape)
    return 1.0 + SLOPE[0] * u + SLOPE[1] * v[:, None]


def _blurred(light: Array, blur_px: float) -> Array:
    return np.asarray(cv2.GaussianBlur(light, (0, 0), blur_px)) if blur_px else light
