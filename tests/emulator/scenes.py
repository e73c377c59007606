"""Scenes for images: a camera 0.3 m above a table, and a laser plane across its view."""

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array, Image
from robolaser.emulator.world.scene import CameraModel, CameraSettings, Projector, RenderedScene
from robolaser.emulator.world.solids import Solid
from robolaser.trials.synthetic.scanner import Light, ScannerOptics

TRUTH = {
    "f": 8e-3, "s_u": 7.4e-6, "s_v": 7.3e-6, "u_0": 322.0, "v_0": 238.0, "k": 800.0, "b": 0.14,
    "theta": float(np.radians(25.0)), "w": 0.01, "phi": -0.02, "psi": 0.03, "t_x": 0.07, "t_y": 0.0, "t_z": -0.06,
}  # fmt: skip
LENS_ERROR = np.array([0.0, 0.0, 4e-4, -3e-4, 0.02])
SPOTLESS = CameraSettings(ambient_grey=0.0, noise_grey=0.0)
"""Without noise and ambient light."""
MIDDLE = np.array([0.4, 0.0, 0.0])


def light(roll: float = 0.0, cone: float = 0.0) -> Light:
    return Light(TRUTH["b"], *(np.array(angle) for angle in (TRUTH["theta"], roll, cone)))


def eye(stripe_axis: str = "v", **settings: float) -> CameraModel:
    made = replace(_spotless(stripe_axis), settings=replace(SPOTLESS, **settings))
    vars(made)["all_rays"] = _spotless(stripe_axis).all_rays  # takes a second, and does not depend on the settings
    return made


@cache
def _spotless(stripe_axis: str) -> CameraModel:
    optics = ScannerOptics(TRUTH, (0.0, 0.0, 0.0, 1.0), "xyz", stripe_axis)
    return CameraModel(optics, optics.lens + LENS_ERROR)


def scene(
    *solids: Solid, stripe_axis: str = "v", projector: Projector | None = None, **settings: float
) -> RenderedScene:
    """A scene, by default without noise, speckle and ambient light."""
    return RenderedScene(solids, eye(stripe_axis, **settings), light(), projector or Projector(speckle=0.0))


def grey(scene: RenderedScene, T_base_camera: Array, *, lit: bool = True) -> Array:
    """The image without noise, speckle and saturation, (height, width)."""
    room, laser = scene.render(T_base_camera)
    return scene.eye.settings.ambient_grey * room + lit * laser


def photograph(scene: RenderedScene, T_base_camera: Array, *, lit: bool = True, seed: int = 1) -> Image:
    rng = np.random.default_rng(seed)
    room, laser = scene.render(T_base_camera)
    return scene.expose(room, lit * laser, rng=rng, grain=rng)


def near(x: float, y: float, z: float) -> tuple[float, float, float]:
    """A point relative to the middle of the view."""
    return MIDDLE[0] + x, MIDDLE[1] + y, MIDDLE[2] + z


def heading(degrees: float) -> tuple[float, float, float, float]:
    """A rotation about the vertical as a quaternion."""
    x, y, z, w = Rotation.from_euler("z", degrees, degrees=True).as_quat().tolist()
    return x, y, z, w


def above(*tilt_deg: float, height: float = 0.3) -> Array:
    """T_base_camera of a view on the middle, rotated by roll, pitch and heading."""
    T = np.eye(4)
    turn = Rotation.from_euler("xyz", tilt_deg or (8, 5, 20), degrees=True).as_matrix()
    T[:3, :3] = np.diag([1.0, -1.0, -1.0]) @ turn
    T[:3, 3] = MIDDLE - height * T[:3, 2]
    return T


def face_up(point: tuple[float, float, float]) -> Array:
    """T_base_board of a board on the table."""
    T = np.diag([1.0, -1.0, -1.0, 1.0])
    T[:3, 3] = point
    return T
