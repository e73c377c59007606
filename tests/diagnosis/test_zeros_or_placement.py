"""Wrong zeros of neighbouring joints that are parallel, and the placement of the second: neither is named for certain
where the poses do not tell."""

import numpy as np

import robolaser
from robolaser.data.stated_noise import Noise
from robolaser.results.diagnosis import DiagnosisResult
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

ZEROS = {
    "joint_offset:shoulder_lift": np.radians(1.15),
    "joint_offset:elbow_flex": np.radians(-1.72),
    "joint_offset:wrist_flex": np.radians(1.43),
}
SUSPECTS = ["joint_offset", "link_geometry", "encoder_scale", "joint_compliance", "target_scale"]


def diagnosed(effects: dict[str, float], seed: int) -> DiagnosisResult:
    made = simulate(
        find_robot("so101"), kind="camera", poses=40, points=12, noise=Noise(pixel_px=0.3, joint_rad=5e-4),
        effects=effects, options=CellOptions(mount="base", placed=False), seed=seed,
    )  # fmt: skip
    return robolaser.diagnose(made.dataset, effects=SUSPECTS, seed=0)


def test_three_wrong_zeros_are_never_one_placement_for_certain() -> None:
    why = diagnosed(ZEROS, 2)
    assert why.verdict == "explained"
    assert why.classes[0]["class"] == "arm_geometry"
    named = {(one.effect, one.where): one for one in why.effects}
    for zero in ZEROS:
        pair = tuple(zero.split(":"))
        assert pair in named or any(list(pair) in one.indistinguishable_from for one in why.effects)
    assert all(one.probability < 0.9 for (effect, _), one in named.items() if effect == "link_geometry")
    assert all(kind["probability"] < 0.9 for kind in why["kinds"] if kind["effect"] == "link_geometry")


def test_a_placement_that_zeros_could_imitate_has_them_as_rivals() -> None:
    (found,) = diagnosed({"link_geometry:wrist_flex": 3e-3}, 1).effects
    assert (found.effect, found.where) == ("link_geometry", "wrist_flex")
    assert found.probability < 0.9
    assert ["joint_offset", "elbow_flex"] in [list(pair) for pair in found.indistinguishable_from]
