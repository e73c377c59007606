"""A diagnosis grows with its poses: as a fresh one says, without examining all poses again."""

from dataclasses import replace

import numpy as np
import pytest

import robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.joining import poses_beyond, with_poses_of
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.further_poses import Followed, FurtherRows
from robolaser.diagnosis.growth import with_poses
from robolaser.diagnosis.thresholds import SMALL_SHARE
from robolaser.errors import DataError, UsageError
from robolaser.estimation.averaging import AveragedData
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.tracker_scale import TrackerScale
from robolaser.model.forward_model import of_data
from robolaser.model.noise.sources import error_sources
from robolaser.results.diagnosis import DiagnosisResult
from robolaser.simulation import CellOptions, simulate

FIRST = 60
FEW = ["backlash", "joint_offset", "encoder_scale", "link_geometry", "joint_compliance", "tracker_scale"]


@pytest.fixture(scope="module")
def arm() -> Dataset:
    effects = {"backlash:elbow_joint": 0.0004, "joint_offset:wrist_1_joint": 0.0006}
    noise = Noise(point_m=1e-4)
    return simulate("ur5", kind="point", poses=FIRST + 10, noise=noise, effects=effects, seed=4).dataset


@pytest.fixture(scope="module")
def other() -> Dataset:
    return simulate("ur5", kind="point", poses=20, noise=Noise(point_m=1e-4), seed=5).dataset


@pytest.fixture(scope="module")
def found(arm: Dataset, other: Dataset) -> DiagnosisResult:
    return robolaser.diagnose(first(arm, FIRST), effects=FEW, seed=1, validate=[other])


def first(dataset: Dataset, count: int) -> Dataset:
    return dataset.of_poses(np.arange(len(dataset.poses)) < count)


def told(result: DiagnosisResult) -> dict[tuple[str, str], float]:
    return {(one.effect, one.where): one.probability for one in result.effects}


def test_further_poses_give_the_names_of_a_fresh_diagnosis_and_its_probabilities(arm, found):
    grown, fresh = found, robolaser.diagnose(first(arm, FIRST + 3), effects=FEW, seed=1)
    for count in range(FIRST + 1, FIRST + 4):
        grown = grown.with_poses(first(arm, count))
    assert grown.diagnosis.weighed.followed
    assert told(grown) == pytest.approx(told(fresh), abs=0.02)
    assert grown.poses == fresh.poses == {"used": FIRST + 3, "all": FIRST + 3}
    assert {one["class"]: one.probability for one in grown.classes} == pytest.approx(
        {one["class"]: one.probability for one in fresh.classes}, abs=0.02
    )


def test_poses_of_another_arm_are_refused(found):
    other = simulate("panda", kind="point", poses=FIRST, noise=Noise(point_m=1e-4), seed=4).dataset
    with pytest.raises(DataError, match="Both must be of the same arm"):
        found.with_poses(other)


def test_what_is_added_one_by_one_or_at_once_alone_or_with_the_rest_is_the_same(arm, found):
    one_by_one = found.with_poses(first(arm, FIRST + 1)).with_poses(first(arm, FIRST + 2))
    at_once = found.with_poses(first(arm, FIRST + 2))
    further = first(arm, FIRST + 2).of_poses(np.arange(FIRST + 2) >= FIRST)
    assert told(at_once) == pytest.approx(told(one_by_one), abs=1e-3)
    assert told(found.with_poses(further)) == pytest.approx(told(at_once), abs=1e-12)


def test_parameters_and_their_standard_errors_are_the_same_one_by_one_or_at_once(arm, found):
    one_by_one = found
    for count in range(FIRST + 1, FIRST + 4):
        one_by_one = one_by_one.with_poses(first(arm, count))
    at_once = found.with_poses(first(arm, FIRST + 3))
    std = at_once.diagnosis.std
    assert np.nanmin(std / found.diagnosis.std) < 0.99
    assert one_by_one.diagnosis.std == pytest.approx(std, rel=1e-4, nan_ok=True)
    for name in ("x", "calibrated_x"):
        grown, whole = (getattr(one.diagnosis, name) for one in (one_by_one, at_once))
        assert np.nanmax(np.abs(grown - whole) / std[: len(whole)]) < 0.01


def test_a_followed_model_is_the_one_that_a_fit_of_all_rows_finds(arm, found):
    weighed = found.diagnosis.weighed
    further = first(arm, FIRST + 3).of_poses(np.arange(FIRST + 3) >= FIRST)
    rows = FurtherRows.of(weighed.start, weighed.dataset, further)
    followed = Followed.of(weighed.final).with_rows(rows)
    model = of_data(weighed.final.model, rows.dataset)
    shots = AveragedData.single(rows.dataset).shots
    sources = error_sources(model.with_effects(()), weighed.start.x, shots)
    problem = problem_of(model, replace(weighed.start.noise, sources=sources), weighed.final.sensor)
    fit = Fit.of(problem, weighed.final.x)
    assert np.abs(followed.x - fit.x).max() / fit.deviations.max() < 0.02
    assert weighed.final.chi2 + followed.added == pytest.approx(fit.chi2, abs=0.05)
    assert followed.narrowed(Followed.of(weighed.final)).max() <= 1.0 + 1e-9


def test_repeats_of_a_further_pose_weigh_as_those_of_the_others():
    noise, repeated = Noise(point_m=1e-4), CellOptions(repeats=4)
    made = simulate("ur5", kind="point", poses=25, noise=noise, seed=3, options=repeated).dataset
    weighed = robolaser.diagnose(first(made, 24), effects=FEW, seed=1).diagnosis.weighed
    rows = FurtherRows.of(weighed.start, weighed.dataset, made.of_poses(np.arange(25) >= 24))
    (known,) = [one.effect for one in weighed.start.noise.sources if one.name == "point"]
    (new,) = [one.effect for one in rows._noise.sources if one.name == "point"]
    np.testing.assert_allclose(np.linalg.norm(new[0]), np.linalg.norm(known[0]), rtol=1e-6)


def test_a_grown_diagnosis_still_says_whether_it_carries_over_and_what_it_may_stand_for(arm, other, found):
    grown = found.with_poses(first(arm, FIRST + 1))
    assert grown.diagnosis.weighed.followed
    assert grown.sentence.partition(f"to {other.name}")[2] == found.sentence.partition(f"to {other.name}")[2] != ""
    like = replace(found.diagnosis.limits[0], candidate_effect=CandidateEffect(TrackerScale, "measuring_system"))
    imitated = replace(found.diagnosis, limits=(replace(like, size=None, is_imitated=True),))
    further = first(arm, FIRST + 1)
    assert "cannot distinguish tracker scale" in with_poses(imitated, further, robolaser.diagnosis.examine).sentence


def test_a_pose_that_the_model_does_not_predict_has_all_poses_examined_anew(arm, found):
    points = first(arm, FIRST + 1).points
    off = replace(points, xyz=points.xyz + 2e-3 * (points.pose == FIRST)[:, None])
    assert not found.with_poses(replace(first(arm, FIRST + 1), points=off)).diagnosis.weighed.followed


def test_after_a_twentieth_more_poses_all_are_examined_anew(arm, found):
    assert not found.with_poses(first(arm, FIRST + int(SMALL_SHARE * FIRST) + 1)).diagnosis.weighed.followed


def test_a_grown_diagnosis_has_files_of_its_own(tmp_path):
    offset, noise = {"joint_offset:joint_3": 0.003}, Noise(point_m=1e-4)
    arm = simulate("scorbot_er7", kind="point", poses=21, noise=noise, effects=offset, seed=4).dataset
    grown = robolaser.diagnose(first(arm, 20), effects=["joint_offset"], seed=1).with_poses(arm)
    assert grown.diagnosis.weighed.followed
    grown.save(tmp_path / "why")
    assert (tmp_path / "why" / "corrected.py").is_file()
    back = robolaser.load_diagnosis(tmp_path / "why")
    assert told(back) == told(grown)
    with pytest.raises(UsageError, match="read back"):
        back.with_poses(arm)


def test_a_longer_data_set_begins_with_a_shorter_one_only_if_its_rows_are_the_same(arm):
    shorter, longer = first(arm, 5), first(arm, 7)
    assert poses_beyond(shorter, longer).poses.names == arm.poses.names[5:7]
    moved = replace(longer, points=replace(longer.points, xyz=longer.points.xyz + 1e-6))
    assert poses_beyond(shorter, moved) is None
    assert poses_beyond(longer, shorter) is None


def test_poses_of_one_name_are_no_further_poses(arm):
    with pytest.raises(DataError, match=arm.poses.names[4]):
        with_poses_of(first(arm, 5), first(arm, 7).of_poses(np.arange(7) >= 4))
