"""Simulated cameras: what is wrong with arm, bracket, lens or target is named as for a stripe scanner."""

import pytest
from worlds import kinds

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

CASES = [
    ("flange", "", 0.0),
    ("flange", "joint_offset:elbow_joint", 1e-3),
    ("base", "hand_eye_drift:hand_eye", 5e-4),
    ("flange", "target_scale:target", 0.12),  # squares of another print
    ("flange", "radial_distortion:camera", 1e8),
    ("flange", "tangential_distortion:camera", 0.1),
]
SUSPECTS = kinds(
    "joint_offset", "encoder_scale", "hand_eye_drift", "hand_eye_sag", "camera_drift", "focus_breathing",
    "radial_distortion", "tangential_distortion", "target_scale", "target_stretch", "target_warp",
)  # fmt: skip


@pytest.mark.parametrize(("mount", "effect", "size"), CASES)
def test_a_single_cause_is_named_and_nothing_else(mount: str, effect: str, size: float) -> None:
    made = simulate(
        find_robot("ur5"), kind="camera", poses=30, points=20, noise=Noise(pixel_px=0.1),
        effects={effect: size} if effect else None, options=CellOptions(mount=mount, placed=False), seed=5,
    )  # fmt: skip
    found = examine(made.dataset, SUSPECTS, seed=0)
    assert [str(one.candidate_effect) for one in found.findings] == [effect.replace(":", " at ")] * bool(effect)
    assert found.verdict == ("explained" if effect else "no_gap")
    assert found.gap.after_m == pytest.approx(found.gap.noise_floor_m, rel=0.15)
    for one in found.findings:
        assert one.probability > 0.9
