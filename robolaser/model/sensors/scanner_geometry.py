"""The head of a stripe scanner, camera and laser on their bracket, for any target."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.camera import intersect, laser_plane, metric, rays, undistort
from robolaser.geometry.rigid_motion import apply, carry, from_angles, from_quaternion, pose
from robolaser.model.sensors.in_cell import CameraView
from robolaser.model.sensors.placements import motion
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values, from_batch
from robolaser.robot.visibility import View

USUAL_IMAGE_PX = (640, 480)


def in_image(pixel: Array, values: Values, perturb: Perturbation) -> Array:
    """Undistorted metric image points of pixels (c or 1, m, 2), (c, m, 2) [m]. Eqs. 2-4."""
    read = perturb(Stage.PIXELS, pixel)
    return perturb(Stage.IMAGE, undistort(metric(read, values), values["k"]))


def in_camera(pixel: Array, values: Values, perturb: Perturbation, stripe_axis: str) -> Array:
    """Points on the laser plane that pixels (c or 1, m, 2) show, in the camera frame, (c, m, 3) [m]. Eqs. 1-6."""
    ray = rays(in_image(pixel, values, perturb), values["f"], stripe_axis)
    return perturb(Stage.POINTS, intersect(ray, perturb(Stage.LASER_PLANE, laser_plane(values))))


def in_base(
    dataset: Dataset, values: Values, T_base_flange: Array, perturb: Perturbation, pixel: Array | None = None
) -> Array:
    """Points that pixels (1, m, 2) show, those measured if none are given, in the base frame, (c, m, 3) [m].

    Eqs. 9, 11, 13.
    """
    pixel = dataset.points["pixel"][None] if pixel is None else pixel
    seen = in_camera(pixel, values, perturb, dataset.stripe_axis)
    return carry(T_base_flange @ mount(dataset, values, perturb), dataset.points.pose, seen)


def view_of(dataset: Dataset, values: Values) -> View:
    """The scanner's view from the flange by its parameters alone, one candidate."""
    T_flange_camera = mount(dataset, values, Perturbation())[0, 0]
    return View(T_flange_camera, from_batch(values), dataset.stripe_axis, dataset.image_px or USUAL_IMAGE_PX)


def camera_view(values: Values, perturb: Perturbation) -> CameraView:
    """The scanner's camera, one candidate, with effects of the lens but without bias of the stripe's centre."""
    perturb = perturb.of_lens
    f, s_u, s_v, u_0, v_0 = (float(values[name][0]) for name in ("f", "s_u", "s_v", "u_0", "v_0"))

    def slopes(pixel: Array) -> Array:
        undistorted = undistort(metric(pixel[None], values), values["k"])
        straight: Array = perturb(Stage.IMAGE, undistorted)[0] / f
        return straight

    return CameraView(np.array([[f / s_u, 0.0, u_0], [0.0, f / s_v, v_0], [0.0, 0.0, 1.0]]), slopes)


def frames(dataset: Dataset, values: Values, perturb: Perturbation) -> dict[str, Array]:
    """T_flange_frame of the scanner's parts by name, one candidate: the camera, its optical frame, the laser.

    The optical frame has x along image u and y along v. The laser's has its plane as y-z, z along the camera's view in
    it, and its origin where the plane crosses the camera's x axis.
    """
    T_flange_camera = mount(dataset, values, perturb)[0, 0]
    return {
        "scanner_camera": T_flange_camera,
        "scanner_camera_optical": T_flange_camera @ optical(dataset),
        "scanner_laser": T_flange_camera @ _laser(perturb(Stage.LASER_PLANE, laser_plane(values))[0, 0]),
    }


def optical(dataset: Dataset) -> Array:
    """T_camera_optical: x along image u and y along v, OpenCV's axes, in the scanner's camera frame, (4, 4)."""
    R = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) if dataset.stripe_axis == "u" else np.eye(3)
    return pose(R, np.zeros(3))


def target(dataset: Dataset, values: Values, perturb: Perturbation) -> Array:
    """The target points, in the base frame, (c or 1, m, 3) [m]."""
    points = perturb(Stage.TARGET, dataset.points["xyz"][None])
    return points if dataset.placed else apply(motion(values, "target")[:, None], points)


def _laser(plane: Array) -> Array:
    """T_camera_laser of the plane (n, d)."""
    length = np.linalg.norm(plane[:3])
    normal, d = plane[:3] / length, plane[3] / length
    view = np.array([0.0, 0.0, 1.0])
    z = view - (view @ normal) * normal
    z /= np.linalg.norm(z)
    return pose(np.column_stack([normal, np.cross(z, normal), z]), np.array([d / normal[0], 0.0, 0.0]))


def mount(dataset: Dataset, values: Values, perturb: Perturbation) -> Array:
    """T_flange_camera, (c, n or 1, 4, 4). Eqs. 9-10."""
    bracket = from_quaternion(np.array(dataset.bracket_quat))
    turn = from_angles(values["w"], values["phi"], values["psi"], order=dataset.angles)
    shift = np.stack([values["t_x"], values["t_y"], values["t_z"]], axis=-1)
    return perturb(Stage.MOUNT, pose(bracket @ turn, shift)[:, None])
