"""A model's derivatives agree with differences of one parameter each, whatever sensors and effects it has."""

from dataclasses import replace

import numpy as np
import pytest
from asked import simulate_as_asked
from differences import central_differences
from several import two_trackers

from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model, jacobian
from robolaser.robot.by_name import find_robot

KINDS = ("stripe", "camera", "point", "pose", "profile", "socket")
OF_A_CAMERA = (
    "latency", "link_geometry:elbow_joint", "base_shift", "hand_eye_drift", "radial_distortion", "target_warp",
)  # fmt: skip
OF_A_SCANNER = (
    "joint_offset:elbow_joint", "joint_compliance:elbow_joint", "encoder_eccentricity:elbow_joint",
    "link_geometry:elbow_joint", "link_geometry:wrist_1_joint", "base_shift", "hand_eye_drift", "stripe_bias",
    "radial_distortion", "tangential_distortion", "laser_roll", "laser_drift", "laser_curvature", "target_scale",
    "target_warp",
)  # fmt: skip
BENT = {"speed": 0.05, "effects": {"radial_distortion": 1e7}}  # whose lens has not all radial terms of its own
OF_BOTH = ("laser_roll", "radial_distortion", "hand_eye_drift", "joint_offset:elbow_joint")


def cell(kind: str = "stripe", **options: object) -> Dataset:
    return simulate_as_asked(find_robot("ur5"), kind=kind, **{"poses": 8, "seed": 1, **options}).dataset


CASES = {
    **{kind: (lambda kind=kind: cell(kind), ()) for kind in KINDS},
    **{f"{kind}, an effect": (lambda kind=kind: cell(kind), ("joint_offset:elbow_joint",)) for kind in KINDS},
    **{
        f"{kind}, sessions": (lambda kind=kind: cell(kind, sessions=2, placed=False), ("joint_offset:elbow_joint",))
        for kind in KINDS
    },
    "along v": (lambda: cell(stripe_axis="v", bracket_quat=(0.1, 0.3, -0.2, 0.9)), ()),
    "angles of the paper": (lambda: replace(cell(), angles="zyz"), ()),
    "all stages": (cell, OF_A_SCANNER),
    "all stages, unplaced": (lambda: cell(placed=False), OF_A_SCANNER),
    "bodies far off": (lambda: cell("pose", points=2, noise=Noise(point_m=1e-3, angle_rad=0.3)), ()),
    "profiles of a standing sensor": (lambda: cell("profile", points=2, mount="base"), ()),
    "camera, all stages": (lambda: cell("camera", **BENT), OF_A_CAMERA),
    "camera, all stages, unplaced": (lambda: cell("camera", **BENT, placed=False), OF_A_CAMERA),
    "standing camera, all stages": (lambda: cell("camera", **BENT, placed=False, mount="base"), OF_A_CAMERA),
    "scanner and corners": (lambda: cell("stripe+camera", placed=False, noise=Noise(pixel_px=0.1)), OF_BOTH),
    "scanner and corners along v": (lambda: cell("stripe+camera", placed=False, stripe_axis="v"), OF_BOTH),
    "two trackers": (two_trackers, ("joint_offset:elbow_joint", "backlash:elbow_joint", "tracker_scale")),
}


@pytest.mark.parametrize("case", CASES)
def test_a_models_derivatives_are_those_of_each_parameter_by_itself(case: str) -> None:
    made, effects = CASES[case]
    dataset = made()
    model = Model(dataset, candidate_effects(effects, dataset))
    parameters, rng = model.parameters, np.random.default_rng(0)
    near = parameters.nominal + 1e-3 * parameters.width * rng.uniform(-1.0, 1.0, (2, len(parameters)))
    near = np.clip(near, parameters.lower, parameters.upper)
    for x, slopes in zip(near, jacobian(model, near), strict=True):

        def moved(shares: np.ndarray, x: np.ndarray = x) -> np.ndarray:
            return model.residuals(x + shares * parameters.width)

        expected = central_differences(moved, np.full(len(x), 3e-6))
        found = np.moveaxis(slopes, 0, -1) * parameters.width
        np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-7 * np.abs(expected).max())
