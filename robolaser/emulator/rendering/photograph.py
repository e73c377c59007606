"""A picture as the camera would take it: room light, stripe, mirror images, speckle, blur, noise, end of range."""

from dataclasses import dataclass
from typing import final

import cv2
import numpy as np
from numpy.typing import NDArray

from robolaser.arrays import Array, Ints
from robolaser.emulator.rendering import shading
from robolaser.emulator.rendering.camera import Eye
from robolaser.emulator.rendering.light import Sheet
from robolaser.emulator.rendering.scene import Scene
from robolaser.emulator.rendering.truth import Truth
from robolaser.emulator.rendering.view import View

FINE = 3  # rays a pixel, along u and along v, where something changes within it
REACH = 4.5  # standard deviations of the sheet, beyond which it is dark
SLOPE = (0.25, -0.15)  # of the room's light, from one side of the image to the other, along u and v
MIDDLE_GREY = 128.0
GRAIN_PX = 0.7  # of the speckle
COARSE = 2  # pixels between the rays that look for mirror images


@final
@dataclass(frozen=True)
class Photograph:
    """A grey image, (height, width), and the truth behind it."""

    image: NDArray[np.uint8]
    truth: Truth


def photograph(
    scene: Scene,
    eye: Eye,
    sheet: Sheet,
    T_base_camera: Array,
    *,
    lit: bool,
    rng: np.random.Generator,
    exposure: float = 1.0,
    ambient: float = 90.0,
    noise_grey: float = 2.0,
    speckle: float = 0.1,
    reflections: bool = True,
    blur_px: float = 0.6,
    grain: np.random.Generator | None = None,
) -> Photograph:
    """Take a picture.

    Args:
        scene: Solids in the base frame.
        eye: The camera.
        sheet: The projector, in the camera frame.
        T_base_camera: (4, 4).
        lit: Whether the projector is on.
        rng: Where the noise comes from.
        exposure: Factor on all light.
        ambient: Grey of white paper under the room's light, exposure 1.
        noise_grey: Standard deviation of the noise at middle grey; half its variance is the light's own.
        speckle: Contrast of the speckle: standard deviation over mean.
        reflections: Whether shiny solids mirror the stripe on others.
        blur_px: Standard deviation of the lens's blur [px].
        grain: Where the speckle comes from, which is the same while nothing moves; absent: `rng`.
    """
    view = View(scene, eye, T_base_camera)
    hits = view.all
    room = shading.of_the_room(view, hits)
    laser = np.zeros(len(room))
    rows = _outlines(view) if not lit else np.union1d(_outlines(view), _near_the_sheet(view, sheet))
    if lit and reflections and _mirrors_something(view):
        rows = np.union1d(rows, _near_mirror_images(view, sheet))
    fine = view.along(_fine_rays(eye, rows))

    def mean(light: Array) -> Array:
        return np.asarray(light.reshape(-1, FINE * FINE).mean(axis=1))

    room[rows] = mean(shading.of_the_room(view, fine))
    if lit:
        light = shading.of_the_laser(view, sheet, fine)
        if reflections:
            light += shading.mirrored(view, sheet, fine)
        laser[rows] = mean(light)
    shape = eye.height_px, eye.width_px
    room = _blurred(ambient * (room.reshape(shape) * _falling_off(shape)), blur_px)
    laser = _blurred(laser.reshape(shape), blur_px)
    grey = exposure * (room + laser)
    seen = grey
    if lit and speckle:
        seen = exposure * (room + laser * _speckled(shape, speckle, rng if grain is None else grain))
    if noise_grey:
        spread = noise_grey * np.sqrt(0.5 + 0.5 * seen / MIDDLE_GREY)
        seen = seen + spread * rng.standard_normal(shape, dtype=np.float32)
    image = np.clip(np.rint(seen), 0, 255).astype(np.uint8)
    return Photograph(image, Truth(view, sheet, lit, grey))


def _mirrors_something(view: View) -> bool:
    """Whether anything mirrors."""
    return bool((view.scene.shine > 0).any())


def _outlines(view: View) -> Ints:
    """Pixels beside which another solid, or another face, shows."""
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


def _near_the_sheet(view: View, sheet: Sheet) -> Ints:
    """Pixels that the stripe may reach."""
    with np.errstate(invalid="ignore"):
        near = np.abs(sheet.off(view.all.seen)) < REACH * sheet.width_m + _breadth(view)
    return np.flatnonzero(near & (view.all.solid >= 0))


def _breadth(view: View) -> Array:
    return view.all.distance * view.eye.pixel_rad


def _near_mirror_images(view: View, sheet: Sheet) -> Ints:
    """Pixels around what a coarse grid of rays finds mirrored."""
    shape = view.eye.height_px, view.eye.width_px
    rows = np.arange(shape[0] * shape[1]).reshape(shape)[::COARSE, ::COARSE].ravel()
    found = np.zeros(shape, dtype=np.uint8)
    found.ravel()[rows] = shading.mirrored(view, sheet, view.all.take(rows)) > 0
    return np.flatnonzero(cv2.dilate(found, np.ones((2 * COARSE + 3, 2 * COARSE + 3), np.uint8)))


def _fine_rays(eye: Eye, rows: Ints) -> Array:
    """Rays through the parts of pixels, part by part, (n * FINE², 3)."""
    part = (np.arange(FINE) + 0.5) / FINE - 0.5
    right, down = (grid.ravel()[:, None] for grid in np.meshgrid(part, part))
    along_u, along_v = (slope.reshape(-1, 3)[rows] for slope in eye.slopes)
    ray = eye.all_rays.reshape(-1, 3)[rows]
    fine = ray[:, None] + right * along_u[:, None] + down * along_v[:, None]
    unit: Array = (fine / np.linalg.norm(fine, axis=-1, keepdims=True)).reshape(-1, 3)
    return unit


def _falling_off(shape: tuple[int, int]) -> Array:
    """The room's light over the image: brighter on one side, (height, width)."""
    v, u = (np.linspace(-0.5, 0.5, length) for length in shape)
    return 1.0 + SLOPE[0] * u + SLOPE[1] * v[:, None]


def _blurred(light: Array, blur_px: float) -> Array:
    return np.asarray(cv2.GaussianBlur(light, (0, 0), blur_px)) if blur_px else light


def _speckled(shape: tuple[int, int], contrast: float, rng: np.random.Generator) -> Array:
    """Factors around 1, log-normal, in grains, (height, width)."""
    field = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), GRAIN_PX)
    spread = np.sqrt(np.log1p(contrast**2))
    factor: Array = np.exp(spread * field / field.std() - spread**2 / 2)
    return factor
