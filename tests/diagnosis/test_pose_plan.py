"""What a plan promises of poses is what measurements from there turn out to tell."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from robolaser.cli import main
from robolaser.data.dataset import Dataset, Points
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.diagnosis import examine
from robolaser.diagnosis.pose_plan import examine_plan
from robolaser.errors import DataError, EstimationError, UsageError
from robolaser.model.effects.backlash import Backlash
from robolaser.model.effects.encoder_scale import EncoderScale
from robolaser.model.effects.joint_compliance import JointCompliance
from robolaser.model.effects.joint_offset import JointOffset
from robolaser.model.effects.latency import Latency
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

NOISE = Noise(pixel_px=0.1, point_m=3e-5, angle_rad=1e-4, joint_rad=2e-5)
FEW = [JointOffset, JointCompliance, EncoderScale, Backlash]


def bare(dataset: Dataset) -> Dataset:
    """The poses alone, with the expected noise."""
    nothing = Points(np.empty(0, dtype=np.int64), ())
    return Dataset("plan", dataset.poses, nothing, kind=dataset.kind, robot=dataset.robot, noise=NOISE)


def test_sizes_are_those_that_a_diagnosis_of_such_measurements_states() -> None:
    measured = simulate(find_robot("scorbot_er7"), kind="point", poses=30, noise=NOISE, seed=3).dataset
    said = {one.candidate_effect: one.size for one in examine(measured, FEW).limits}
    promised = {one.candidate_effect: one.size for one in examine_plan(bare(measured), FEW).limits}
    assert promised.keys() == said.keys()
    ratios = [promised[one] / said[one] for one in said if said[one] and promised[one]]
    assert len(ratios) > 10
    assert 0.7 < np.median(ratios) < 1.4
    assert min(ratios) > 0.4
    assert max(ratios) < 2.5


@pytest.mark.parametrize(("kind", "share"), [("stripe", 0.7), ("point", 1.0), ("pose", 1.0), ("camera", 1 / 3)])
def test_poses_that_look_at_one_target_see_one_in_the_plan_and_stay_where_they_are(kind: str, share: float) -> None:
    measured = simulate(find_robot("ur5e"), kind=kind, poses=15, seed=5).dataset
    plan = examine_plan(bare(measured), [JointOffset])
    assert plan.seeing >= share * 15  # how a camera will be turned on the flange is not known
    assert np.array_equal(plan.dataset.arm[1], measured.arm[1])


def test_measured_points_are_what_the_poses_see() -> None:
    measured = simulate(find_robot("scorbot_er7"), kind="socket", poses=30, noise=NOISE, seed=1).dataset
    plan = examine_plan(measured, FEW)
    assert plan.seeing == 30
    assert {one.candidate_effect: one.size for one in plan.limits}.keys()


def test_a_joint_that_never_moves_and_one_that_does_are_told_apart_from_nothing_and_something() -> None:
    dataset = bare(simulate(find_robot("scorbot_er7"), kind="point", poses=20, seed=2).dataset)
    q = dataset.arm[1].copy()
    q[:, 2] = q[0, 2]
    plan = examine_plan(replace(dataset, poses=replace(dataset.poses, q=q)), [EncoderScale, JointOffset])
    scales = {one.candidate_effect.where: one for one in plan.limits if one.candidate_effect.effect is EncoderScale}
    at = {(one.effect.name, one.where): i for i, one in enumerate(plan.candidates)}
    assert plan.alike[at["encoder_scale", "joint_3"], at["joint_offset", "joint_3"]] == pytest.approx(1.0, abs=1e-6)
    assert scales["joint_3"].identifiable is None
    assert scales["joint_2"].identifiable is not None


def test_more_poses_show_smaller_effects() -> None:
    few, many = (
        examine_plan(
            bare(simulate(find_robot("scorbot_er7"), kind="point", poses=n, seed=4).dataset), [JointCompliance]
        )
        for n in (12, 48)
    )
    for one, other in zip(few.limits, many.limits, strict=True):
        assert one.size is None or other.size is not None
        assert one.size is None or other.size < one.size, one.candidate_effect.where
    assert few.limits[0].size is None  # no weight bends a joint that turns about the vertical


def test_what_cannot_be_tested_is_said_with_its_reason() -> None:
    plan = examine_plan(
        bare(simulate(find_robot("scorbot_er7"), kind="point", poses=10).dataset), [JointOffset, Latency]
    )
    assert plan.untestable["latency"] == "no joint velocities in the data"


@pytest.mark.parametrize("points", [0, -3])
def test_a_plan_needs_points_in_each_pose(points: int) -> None:
    planned = bare(simulate(find_robot("ur5e"), kind="point", poses=6, noise=Noise(point_m=1e-4)).dataset)
    with pytest.raises(UsageError, match=f"number of points {points}"):
        examine_plan(planned, FEW, points=points)


def test_without_any_noise_or_with_too_few_poses_there_is_no_plan() -> None:
    dataset = bare(simulate(find_robot("scorbot_er7"), kind="point", poses=10).dataset)
    with pytest.raises(DataError, match=r"No noise is stated.*--point-m or --joint-rad"):
        examine_plan(replace(dataset, noise=Noise()))
    with pytest.raises(EstimationError, match="Only 4 of 4 poses"):
        examine_plan(bare(simulate(find_robot("scorbot_er7"), kind="point", poses=4).dataset))
    with pytest.raises(DataError, match="needs an arm"):
        examine_plan(replace(dataset, robot=None))


def test_the_command_takes_a_table_of_poses_or_a_data_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    measured = simulate(find_robot("scorbot_er7"), kind="point", poses=12, noise=NOISE, seed=1).dataset
    save(measured, tmp_path / "cell")
    table = str(tmp_path / "cell" / "poses.csv")
    assert main(["plan", table, "--robot", "scorbot_er7", "--sensor", "point", "--point-m", "3e-5", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["format"] == "robolaser-plan/1"
    assert len(said["correlation"]) == len(said["candidates"]) == len(said["effects"])
    assert said["noise"] == {"point": 3e-5}
    assert main(["plan", str(tmp_path / "cell")]) == 0
    text = capsys.readouterr().out
    assert ": laser tracker, 12 poses" in text
    assert "tracker's probe, position, estimated from the residuals" in text
    assert "distinguishable from" in text
    assert "Not testable: latency" in text
    assert main(["plan", table]) == 2
    assert main(["plan", str(tmp_path / "nowhere.csv")]) == 1
    assert main(["plan", str(tmp_path / "cell"), "--robot", "ur5e"]) == 2
    assert main(["plan", table, "--robot", "scorbot_er7", "--sensor", "pint", "--point-m", "3e-5"]) == 2


def test_a_pose_in_which_the_arm_hits_itself_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    q = {"free": "0.1,-0.4,0.6,0.2,0", "folded": "0,0.5,1.9,1.5,0", "aside": "0.5,-0.2,0.5,0.1,0.3"}
    rows = "".join(f"{name},{values}\n" for name, values in q.items())
    (tmp_path / "poses.csv").write_text("pose,q_joint_1,q_joint_2,q_joint_3,q_joint_4,q_joint_5\n" + rows)
    main(["plan", str(tmp_path / "poses.csv"), "--robot", "scorbot_er7", "--sensor", "point", "--point-m", "3e-5"])
    said = capsys.readouterr().err
    assert "folded: link_2 and link_5 overlap by" in said
    assert "free:" not in said
