"""The head of a stripe scanner, camera and light sheet on their bracket, whatever it is pointed at."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry import camera as optics
from robolaser.geometry.rigid_motion import from_angles, from_quaternion, pose
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values


def in_image(pixel: Array, values: Values, perturb: Perturbation) -> Array:
    """Metric image points of pixels (c or 1, m, 2), distortion taken off, (c, m, 2) [m]. Eqs. 2-4."""
    read = perturb(Stage.PIXELS, pixel)
    return perturb(Stage.IMAGE, optics.undistort(optics.metric(read, values), values["k"]))


def in_camera(pixel: Array, values: Values, perturb: Perturbation, stripe_axis: str) -> Array:
    """Points on the sheet that pixels (c or 1, m, 2) show, in the camera frame, (c, m, 3) [m]. Eqs. 1-6."""
    ray = optics.rays(in_image(pixel, values, perturb), values["f"], stripe_axis)
    return perturb(Stage.POINTS, optics.cut(ray, perturb(Stage.LASER_PLANE, optics.sheet(values))))


def mount(dataset: Dataset, values: Values, perturb: Perturbation) -> Array:
    """T_flange_camera, (c, n or 1, 4, 4). Eqs. 9-10."""
    bracket = from_quaternion(np.array(dataset.bracket_quat))
    turn = from_angles(values["w"], values["phi"], values["psi"], order=dataset.angles)
    shift = np.stack([values["t_x"], values["t_y"], values["t_z"]], axis=-1)
    return perturb(Stage.MOUNT, pose(bracket @ turn, shift)[:, None])
