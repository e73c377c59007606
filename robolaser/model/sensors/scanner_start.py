"""Start values of a stripe scanner with nothing given: camera and bracket from board corners, then the laser plane."""

from collections.abc import Mapping

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.errors import EstimationError
from robolaser.geometry.rigid_motion import carry, from_quaternion, inverse, rigid_fit, to_angles
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.camera_start import FEWEST_PLACED, CameraStart
from robolaser.model.sensors.placements import motion, six_names, six_of
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

FOCAL_LENGTH_M = 8e-3  # images do not separate the focal length from the size of a pixel: a usual lens
LENS = ("k2", "p1", "p2", "k3")
BEND = 0.5  # share by which a lens may move the image's corner
LASER_SPAN_RAD = 0.5


def camera_start(corners: Dataset, known: Values, T_base_flange: Array) -> dict[str, Array]:
    """The scanner's parameters of its camera, and `target.*`: OpenCV's from the corners, in the scanner's terms.

    Args:
        corners: Pixels and positions of a board's corners, the scanner's axes and bracket.
        known: Given parameters, (1,) each; of these the focal length is kept.
        T_base_flange: (1, n, 4, 4).

    Raises:
        EstimationError: The images or the flange's poses do not determine them.
    """
    closed = CameraStart(corners, corners.image_px or scanner_geometry.USUAL_IMAGE_PX, rides=True)
    found = closed.initialize(dict.fromkeys(LENS, np.zeros(1)), T_base_flange)
    f = known.get("f", np.array([FOCAL_LENGTH_M]))
    T_flange_optical = motion(found, "hand_eye")
    R_flange_camera = T_flange_optical[:, :3, :3] @ scanner_geometry.optical(corners)[:3, :3].T
    turn = from_quaternion(np.array(corners.bracket_quat)).T @ R_flange_camera
    mount = (*to_angles(turn, order=corners.angles), *T_flange_optical[:, :3, 3].T)
    return {
        "f": f,
        "s_u": f / found["fx"],
        "s_v": f / found["fy"],
        "u_0": found["cx"],
        "v_0": found["cy"],
        "k": -found["k1"] / f**2,
        **dict(zip(("w", "phi", "psi", "t_x", "t_y", "t_z"), mount, strict=True)),
        **{name: found[name] for name in six_names("target") if name in found},
    }


def target_by_corners(corners: Dataset, values: Values, T_base_flange: Array) -> dict[str, Array]:
    """`target.*` by the boards that a known camera sees, (c,) each; arguments as for `camera_start`."""
    f, K = values["f"], values["k"] * values["f"] ** 2
    series = {"k1": -K, "k2": 3.0 * K**2, "k3": -12.0 * K**3}  # series of the inverse of the paper's polynomial
    pinhole = {"fx": f / values["s_u"], "fy": f / values["s_v"], "cx": values["u_0"], "cy": values["v_0"]}
    T_flange_optical = scanner_geometry.mount(corners, values, Perturbation())[:, 0] @ scanner_geometry.optical(corners)
    lens = {**series, "p1": np.zeros_like(f), "p2": np.zeros_like(f)}
    known = {**pinhole, **lens, **six_of(T_flange_optical, "hand_eye")}
    image_px = corners.image_px or scanner_geometry.USUAL_IMAGE_PX
    found = CameraStart(corners, image_px, rides=True, most=FEWEST_PLACED).initialize(known, T_base_flange)
    return {name: found[name] for name in six_names("target")}


def target_by_stripe(stripe: Dataset, values: Values, T_base_flange: Array, perturb: Perturbation) -> dict[str, Array]:
    """`target.*` by a rigid fit of the stripe's points, (c,) each; candidates at a pole get the identity."""
    seen = scanner_geometry.in_base(stripe, values, T_base_flange, perturb)
    known = np.broadcast_to(perturb(Stage.TARGET, stripe.points["xyz"][None]), seen.shape)
    good = np.isfinite(seen).all(axis=(1, 2))
    T = np.broadcast_to(np.eye(4), (len(seen), 4, 4)).copy()
    if good.any():
        T[good] = rigid_fit(known[good], seen[good])
    return six_of(T, "target")


def laser_start(stripe: Dataset, known: Values, T_base_flange: Array) -> dict[str, Array]:
    """Baseline and angle of the plane through the stripe's points on the board that the camera sees.

    Args:
        stripe: With the stripe's points on the target.
        known: The scanner's other parameters, and `target.*` of an unplaced target, (1,) each.
        T_base_flange: (1, n, 4, 4).

    Raises:
        EstimationError: The points are on one line.
    """
    T_base_camera = T_base_flange @ scanner_geometry.mount(stripe, known, Perturbation())
    points = scanner_geometry.target(stripe, known, Perturbation())
    x, z = carry(inverse(T_base_camera), stripe.points.pose, points)[0][:, [0, 2]].T
    middle = np.array([x.mean(), z.mean()])
    _, breadth, axes = np.linalg.svd(np.stack([x, z], axis=-1) - middle, full_matrices=False)
    if breadth[0] <= 0.0:
        raise EstimationError(
            "The stripe's points are on one line in front of the camera: they do not determine the laser plane. Take"
            " images of the board at several distances."
        )
    normal = axes[1] * np.sign(axes[1][0] or 1.0)
    return {"b": np.array([normal @ middle / normal[0]]), "theta": np.arctan2(normal[1:], normal[:1])}


def spans(values: Mapping[str, float], image_px: tuple[int, int] | None) -> dict[str, float]:
    """Largest distance of parameters of lens and laser plane from their start values, by name."""
    width, height = image_px or scanner_geometry.USUAL_IMAGE_PX
    corner = float(np.hypot(width * values["s_u"], height * values["s_v"])) / 2.0
    return {
        **{name: values[name] / 2.0 for name in ("f", "s_u", "s_v")},
        "u_0": width / 2.0,
        "v_0": height / 2.0,
        "k": BEND / corner**2,
        "theta": LASER_SPAN_RAD,
    }
