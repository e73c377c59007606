"""Flange poses that somebody measured by centimetres still give a hand-eye, with its error."""

from dataclasses import replace

import numpy as np

from robolaser import calibrate
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.stated_noise import Noise
from robolaser.simulation import simulate


def measured(off_m: float) -> Dataset:
    made = simulate("ur5", kind="camera", poses=12, points=12, seed=2, noise=Noise(pixel_px=0.3)).dataset
    T = np.array(made.flange())
    T[:, :3, 3] += off_m * np.random.default_rng(0).normal(size=(len(T), 3))
    poses = Poses(made.poses.names, T_base_flange=T)
    return replace(made, robot=None, noise=Noise(), parameters={}, placed=False, poses=poses)


def test_a_centimetre_of_noise_is_a_result_with_its_error() -> None:
    found = calibrate(measured(0.008), seed=0)
    assert found.held_out_rms_m > 0.01
    assert not any("Do not use" in warning for warning in found.warnings)
    assert found.files()["static_transform.sh"]


def test_decimetres_are_no_hand_eye() -> None:
    found = calibrate(measured(0.2), seed=0)
    assert any("no measured flange pose has such an error" in warning for warning in found.warnings)
    assert found.files()["static_transform.sh"] is None
