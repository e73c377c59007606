"""What may be several may be given as one, without a list."""

from pathlib import Path

import robolaser
from robolaser.data.stated_noise import Noise
from robolaser.simulation import simulate


def test_one_effect_and_one_data_set_need_no_list(tmp_path: Path) -> None:
    made = simulate("ur5e", kind="point", poses=12, noise=Noise(point_m=1e-4), seed=1).dataset
    folder = tmp_path / "cell"
    robolaser.save(made, folder)
    both = ["joint_offset", "encoder_scale"]
    several = robolaser.diagnose(made, both, without=["encoder_scale"], validate=[folder])
    for validate in (folder, str(folder), robolaser.load(folder)):
        one = robolaser.diagnose(made, both, without="encoder_scale", validate=validate)
        assert one["gap_mm"] == several["gap_mm"]
        assert one["validation"] == several["validation"]


def test_one_name_of_an_effect_is_a_plan() -> None:
    assert robolaser.Plan(effects="laser_roll") == robolaser.Plan(effects=("laser_roll",))


def test_one_problem_and_one_algorithm_need_no_list() -> None:
    result = robolaser.compare("pymoo:sphere-2", "de", seeds=1, budget=100)
    assert result.to_frame()["state"].tolist() == ["done"]
