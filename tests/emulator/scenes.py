"""Scenes to photograph: an eye that looks down on a table from 0.3 m, and a sheet that crosses its view there."""

import numpy as np
from scipy.spatial.transform import Rotation

from robolaser.arrays import Array
from robolaser.emulator.rendering import CameraModel, EmulatedScene, LaserSheet, Photograph, photograph

TRUTH = {
    "f": 8e-3, "s_u": 7.4e-6, "s_v": 7.3e-6, "u_0": 322.0, "v_0": 238.0, "k": 800.0, "b": 0.14,
    "theta": float(np.radians(25.0)), "w": 0.01, "phi": -0.02, "psi": 0.03, "t_x": 0.07, "t_y": 0.0, "t_z": -0.06,
}  # fmt: skip
LENS_ERROR = (0.0, 0.0, 4e-4, -3e-4, 0.02)
SHEET = LaserSheet(TRUTH["b"], TRUTH["theta"])
MIDDLE = np.array([0.4, 0.0, 0.0])


def eye(stripe_axis: str = "v") -> CameraModel:
    return CameraModel(TRUTH, stripe_axis=stripe_axis, lens_error=LENS_ERROR)


def near(x: float, y: float, z: float) -> Array:
    """A point seen from the middle of what is looked at."""
    return MIDDLE + np.array([x, y, z])


def above(*tilt_deg: float, height: float = 0.3) -> Array:
    """T_base_camera with its view on the middle, turned by roll, pitch and heading."""
    T = placed(MIDDLE, *tilt_deg)
    T[:3, :3] = np.diag([1.0, -1.0, -1.0]) @ T[:3, :3]
    T[:3, 3] -= height * T[:3, 2]
    return T


def placed(point: Array, *turn_deg: float) -> Array:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("xyz", turn_deg or (0, 0, 0), degrees=True).as_matrix()
    T[:3, 3] = point
    return T


def face_up(point: Array, heading_deg: float = 0.0) -> Array:
    """T_base_board of a board on the table."""
    T = placed(point, 0, 0, heading_deg)
    T[:3, :3] = T[:3, :3] @ np.diag([1.0, -1.0, -1.0])
    return T


def spotless(scene: EmulatedScene, stripe_axis: str = "v", *tilt_deg: float, **settings: object) -> Photograph:
    """Without noise, speckle and the room's light, if nothing else is said."""
    said = {"lit": True, "noise_grey": 0.0, "speckle": 0.0, "ambient": 0.0, "sheet": SHEET} | settings
    sheet = said.pop("sheet")
    rng = np.random.default_rng(1)
    return photograph(scene, eye(stripe_axis), sheet, above(*tilt_deg or (8, 5, 20)), rng=rng, **said)
