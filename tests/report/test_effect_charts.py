"""Each effect is drawn against what it depends on, with the error that it explains and what it leaves."""

from dataclasses import replace

import numpy as np
import pytest
from few_files import only

import robolaser
from robolaser.data.dataset import Poses
from robolaser.data.stated_noise import Noise
from robolaser.errors import UsageError
from robolaser.report.diagnosis.charts import explained_error
from robolaser.results.diagnosis import DiagnosisResult
from robolaser.simulation import simulate

EFFECTS = {"backlash:elbow_joint": 0.002, "joint_compliance:shoulder_lift_joint": 3e-5}


@pytest.fixture(scope="module")
def why() -> DiagnosisResult:
    made = simulate("ur5", kind="point", poses=28, noise=Noise(point_m=3e-5), effects=EFFECTS, seed=1)
    found = robolaser.diagnose(made.dataset, effects=["backlash", "joint_compliance"])
    with only():
        assert found["files"] == []
    return found


def test_each_pose_shows_the_error_of_the_joint_that_was_simulated(why):
    weighed = why.diagnosis.weighed
    found = {str(one.candidate_effect): explained_error(weighed.final, one) for one in weighed.evidence}
    play, spring = found["backlash at elbow_joint"], found["joint_compliance at shoulder_lift_joint"]
    assert play.coordinate.name == "direction of approach of elbow_joint"
    assert spring.coordinate.name == "gravity torque at shoulder_lift_joint"
    for one in (play, spring):
        assert np.abs(one.left).max() < 0.2 * np.abs(one.moves + one.left).max()
    np.testing.assert_allclose(np.abs(play.moves[play.x != 0.0]), 1e-3, rtol=0.1)


def test_an_encoder_is_drawn_against_its_angle_although_its_error_grows_along_the_run():
    run = simulate("ur5", kind="point", poses=40, noise=Noise(point_m=3e-5), seed=1).dataset
    q = run.poses.q.copy()
    run = replace(run, poses=replace(run.poses, time_s=1.0 + np.sin(q[:, 2])))
    q[:, 2] += 2e-3 * np.sin(q[:, 2])
    found = robolaser.diagnose(replace(run, poses=replace(run.poses, q=q)), effects=["encoder_eccentricity"])
    (one,) = found.diagnosis.weighed.evidence
    assert explained_error(found.diagnosis.weighed.final, one).coordinate.name == "angle of elbow_joint"


def test_the_chart_of_an_effect_is_found_by_its_name_and_place(why, tmp_path):
    assert str(why.plot("backlash", "elbow_joint")) == "Backlash of elbow_joint"
    assert str(why.plot("joint_compliance")) == "Joint compliance of shoulder_lift_joint"
    with pytest.raises(UsageError, match="backlash"):
        why.plot("backlash", "wrist_1_joint")
    why.save(tmp_path / "why")
    again = robolaser.load_diagnosis(tmp_path / "why")
    assert str(again.plot("backlash", "elbow_joint")) == "Backlash of elbow_joint"
    assert "What each effect explains" in (tmp_path / "why" / "report.html").read_text(encoding="utf-8")


def test_without_an_arm_there_is_no_such_chart():
    seen = simulate("ur5", kind="camera", poses=12, points=20, noise=Noise(pixel_px=0.1), seed=2).dataset
    measured = Poses(seen.poses.names, T_base_flange=np.asarray(seen.flange()))
    found = robolaser.diagnose(replace(seen, robot=None, poses=measured), effects=[], seed=0)
    assert "How far the gap shrinks" in str(found.plot())


@pytest.mark.parametrize(
    ("kind", "effect", "size", "noise", "coordinate"),
    [
        ("stripe", "laser_roll", 0.02, Noise(pixel_px=0.1), "pixel"),
        ("camera", "target_scale", 0.004, Noise(pixel_px=0.05), ""),
        ("point", "link_compliance:elbow_joint", 3e-5, Noise(point_m=2e-5), ""),
    ],
)
def test_what_moves_no_joint_is_seen_in_the_points(kind, effect, size, noise, coordinate):
    points = {"stripe": 6, "camera": 12}.get(kind)
    seen = simulate("ur5", kind=kind, poses=16, points=points, noise=noise, effects={effect: size}, seed=3).dataset
    found = robolaser.diagnose(seen, effects=[effect.partition(":")[0]], seed=0).diagnosis
    (evidence,) = (
        one for one in found.weighed.evidence if str(one.candidate_effect).startswith(effect.partition(":")[0])
    )
    one = explained_error(found.weighed.final, evidence)
    assert one.coordinate.name.startswith(coordinate)
    assert one.unit == "m"
    assert np.square(one.left).mean() < 0.05 * np.square(one.moves).mean()
    if one.rival is not None:
        assert np.square(one.rival[1]).mean() < 0.2 * np.square(one.moves).mean()


def test_an_effect_that_cannot_be_distinguished_is_drawn_beside_the_one_that_was_found():
    noise = Noise(point_m=3e-5)
    made = simulate("ur5", kind="point", poses=25, noise=noise, effects={"joint_offset:wrist_1_joint": 0.003}, seed=1)
    found = robolaser.diagnose(made.dataset, effects=["joint_offset", "link_geometry"], seed=0)
    assert any(one.alternatives for one in found.diagnosis.weighed.evidence)
    with only():
        spec = str(found.plot("joint_offset", "wrist_1_joint").spec)
    assert "'left with " in spec.replace("left with it", "")
    assert "'columns': 2" in spec  # the names of both effects beside each other are wider than the chart
