"""A picture as the camera takes it: the light, and the sensor's own speckle, noise and end of range."""

from dataclasses import dataclass
from typing import final

import cv2
import numpy as np
from numpy.typing import NDArray

from robolaser.arrays import Array, Bools
from robolaser.emulator.rendering.camera import CameraModel
from robolaser.emulator.rendering.laser_sheet import LaserSheet
from robolaser.emulator.rendering.radiance_image import RadianceImage, render_radiance
from robolaser.emulator.rendering.scene import EmulatedScene
from robolaser.emulator.rendering.scene_view import SceneView
from robolaser.emulator.rendering.truth import Truth

MIDDLE_GREY = 128.0
GRAIN_PX = 0.7  # of the speckle
WHITE_GREY = 110.0  # of paper in the room's light
DARKEST_GREY = 0.05  # laser light below this has no speckle
NOISE_GREY = 2.0
SPECKLE = 0.1


@final
@dataclass(frozen=True)
class Photograph:
    """A grey image, (height, width), and the truth behind it."""

    image: NDArray[np.uint8]
    truth: Truth


def photograph(
    scene: EmulatedScene,
    eye: CameraModel,
    sheet: LaserSheet,
    T_base_camera: Array,
    *,
    lit: bool,
    rng: np.random.Generator,
    exposure: float = 1.0,
    ambient: float = WHITE_GREY,
    noise_grey: float = NOISE_GREY,
    speckle: float = SPECKLE,
    reflections: bool = True,
    blur_px: float = 0.6,
) -> Photograph:
    """Take a picture of a scene.

    Args:
        scene: Solids in the base frame.
        eye: The camera.
        sheet: The projector, in the camera frame.
        T_base_camera: (4, 4).
        lit: Whether the projector is on.
        rng: Where noise and speckle come from.
        exposure: Factor on all light.
        ambient: Grey of white paper under the room's light, exposure 1.
        noise_grey: Standard deviation of the noise at middle grey; half its variance is the light's own.
        speckle: Contrast of the speckle: standard deviation over mean.
        reflections: Whether shiny solids show the stripe on others, and throw it there.
        blur_px: Standard deviation of the lens's blur [px].
    """
    radiance = render_radiance(
        SceneView(scene, eye, T_base_camera), sheet, lit=lit, reflections=reflections, blur_px=blur_px
    )
    return expose(
        radiance, rng=rng, grain=rng, exposure=exposure, ambient=ambient, noise_grey=noise_grey, speckle=speckle
    )


def expose(
    radiance: RadianceImage,
    *,
    rng: np.random.Generator,
    grain: np.random.Generator,
    exposure: float = 1.0,
    ambient: float = WHITE_GREY,
    noise_grey: float = NOISE_GREY,
    speckle: float = SPECKLE,
) -> Photograph:
    """Take a picture of light; `grain` is where the speckle comes from, which stays while nothing moves."""
    shape = radiance.room.shape
    grey = exposure * (ambient * radiance.room + radiance.laser)
    seen = grey.astype(np.float32)
    if radiance.lit and speckle:
        box = _around(radiance.laser > DARKEST_GREY)
        laser = exposure * radiance.laser[box]
        seen[box] += laser * (_speckled(laser.shape, speckle, grain) - 1.0)
    if noise_grey:
        spread = np.sqrt((0.5 * noise_grey**2 / MIDDLE_GREY) * (seen + MIDDLE_GREY))
        seen = seen + spread * rng.standard_normal(shape, dtype=np.float32)
    image = np.clip(np.rint(seen), 0, 255).astype(np.uint8)
    return Photograph(image, Truth(radiance.view, radiance.sheet, radiance.lit, grey))


def _around(lit: Bools) -> tuple[slice, slice]:
    """Rows and columns that hold all that is lit, with room for a grain."""
    rows, columns = (np.flatnonzero(lit.any(axis=axis)) for axis in (1, 0))
    if len(rows) == 0:
        return slice(0, 0), slice(0, 0)
    return slice(max(rows[0] - 2, 0), rows[-1] + 3), slice(max(columns[0] - 2, 0), columns[-1] + 3)


def _speckled(shape: tuple[int, ...], contrast: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Factors around 1, log-normal, in grains, (height, width)."""
    if 0 in shape:
        return np.ones(shape, dtype=np.float32)
    field = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), GRAIN_PX)
    spread = np.sqrt(np.log1p(contrast**2))
    return np.asarray(np.exp(np.float32(spread / field.std()) * field - np.float32(spread**2 / 2)))
