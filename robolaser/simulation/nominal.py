"""The scanner of the 2004 paper, nominal on any flange, and as it may have been built."""

from collections.abc import Mapping
from itertools import product

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import Quaternion, from_quaternion
from robolaser.model.sensors.stripe import Stripe
from robolaser.parameters import Parameter
from robolaser.robot.kinematics import Robot

IMAGE_PX = (640, 480)
DEGREE = float(np.pi / 180)
DRAWN = {
    "f": (6e-3, 8e-3, 10e-3),
    "s_u": (5e-6, 7.4e-6, 1e-4),
    "s_v": (5e-6, 7.4e-6, 1e-4),
    "u_0": (290.0, 320.0, 340.0),
    "v_0": (200.0, 240.0, 250.0),
    "k": (0.0, 0.0, 1e5),
    "b": (0.1, 0.14, 0.2),
    "theta": (0.0, 25 * DEGREE, 45 * DEGREE),
    "w": (-5 * DEGREE, 0.0, 5 * DEGREE),
    "phi": (-5 * DEGREE, 0.0, 5 * DEGREE),
    "psi": (-5 * DEGREE, 0.0, 5 * DEGREE),
    "t_x": (0.05, 0.07, 0.1),
    "t_y": (-0.01, -0.005, 0.0),
    "t_z": (-0.1, -0.065, -0.05),
}
"""Lower bound, nominal value, upper bound. Bounds: Lee et al. 2004, Table 2; nominal values: a Sony XC-55's pitch and
centre, the rest as measured by a ruler."""

BUILT = {
    "f": 0.16e-3, "s_u": 0.05e-6, "s_v": 0.05e-6, "u_0": 6.0, "v_0": 6.0, "k": 1000.0, "b": 2e-3,
    "theta": 1.5 * DEGREE, "w": 1.5 * DEGREE, "phi": 1.5 * DEGREE, "psi": 1.5 * DEGREE,
    "t_x": 2e-3, "t_y": 2e-3, "t_z": 2e-3,
}  # fmt: skip
"""Tolerances of a workshop's scanner: lenses are made to 2 %, sensors centred to some pixels, brackets bent by
degrees, lengths read from a ruler. Table 2's bounds are wider than any real scanner: its widest pixel pitch, 0.1 mm,
is fourteen times the sensor's own."""

WITHIN = 0.02  # of the bounds' width: the truth is never on a bound


def scanner(bracket_quat: Quaternion) -> dict[str, Parameter]:
    """Nominal values and bounds; the shift on the flange and its bounds turn with the bracket."""
    R = from_quaternion(np.array(bracket_quat))
    shifts = np.array([DRAWN[f"t_{axis}"] for axis in "xyz"])
    corners = np.array(list(product(*shifts[:, ::2]))) @ R.T
    turned = np.stack([corners.min(axis=0), R @ shifts[:, 1], corners.max(axis=0)], axis=1).round(12)
    drawn = DRAWN | {f"t_{axis}": tuple(turned[i].tolist()) for i, axis in enumerate("xyz")}
    unit_of = Stripe.format.unit_of
    return {name: Parameter(name, unit_of(name), mid, low, high) for name, (low, mid, high) in drawn.items()}


def built(
    drawn: Mapping[str, Parameter],
    rng: np.random.Generator,
    about: Mapping[str, float] | None = None,
    most: Mapping[str, float] = BUILT,
    within: float = WITHIN,
) -> dict[str, float]:
    """The scanner as built: each number uniform around its nominal value or `about`, inside the bounds."""
    truth = {}
    for name, item in drawn.items():
        inset = within * (item.upper - item.lower) if name != "k" else 0.0
        value = (item.nominal if about is None else about[name]) + most[name] * rng.uniform(-1.0, 1.0)
        truth[name] = float(np.clip(abs(value) if name == "k" else value, item.lower + inset, item.upper - inset))
    return truth


def facing_outward(robot: Robot) -> Quaternion:
    """The smallest turn of the camera's view onto the last joint's axis, away from the arm.

    On most arms that is the flange's z, and the turn is zero.
    """
    middle = np.clip(0.0, robot.lower, robot.upper)
    T_base_flange, frames = robot.forward(middle), robot.joint_frames(middle)
    axis = T_base_flange[:3, :3].T @ frames[-1, :3, :3] @ robot.axes[robot.chain[-1]]
    behind = (T_base_flange[:3, 3] - frames[:, :3, 3]) @ T_base_flange[:3, :3] @ axis
    telling = behind[np.abs(behind) > 0.01]
    outward = (axis * np.sign(telling[-1]) if len(telling) else axis).round(6)
    return _turn_of_z_to(outward / np.linalg.norm(outward))


def _turn_of_z_to(direction: Array) -> Quaternion:
    x, y, z = (float(part) for part in direction)
    if z < -1 + 1e-9:
        return (1.0, 0.0, 0.0, 0.0)
    quaternion = np.array([-y, x, 0.0, 1.0 + z])
    qx, qy, qz, qw = (quaternion / np.linalg.norm(quaternion)).tolist()
    return (qx + 0.0, qy + 0.0, qz, qw)
