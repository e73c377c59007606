"""Of many poses effects are sought in some, spread over time and configurations; their sizes are of all."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from robolaser import find_robot
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.data.subsampling import MAX_POSES, chosen_rows
from robolaser.diagnosis import Diagnosis, examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.estimation.averaging import AveragedData
from robolaser.model.effects import EFFECTS
from robolaser.report.diagnosis.page import document
from robolaser.simulation import simulate

SEEDS = 0, 1
SUSPECTED = [kind for kind in EFFECTS if kind.name in ("joint_offset", "backlash", "encoder_scale")]


@cache
def tracked(poses: int = 700, **effects: float) -> Dataset:
    wanted = {name.replace("__", ":"): size for name, size in effects.items()}
    noise = Noise(point_m=2e-5)
    return simulate(
        find_robot("ur5e"), kind="point", poses=poses, points=2, noise=noise, effects=wanted, seed=5
    ).dataset


@cache
def examined(seed: int, **effects: float) -> Diagnosis:
    return examine(tracked(**effects), SUSPECTED, seed=seed)


@pytest.fixture(scope="module")
def sound() -> Dataset:
    return tracked()


def kept(dataset: Dataset, seed: int = 0) -> np.ndarray:
    return np.unique(dataset.points.pose[chosen_rows(dataset, seed)])


def test_gross_errors_at_one_reflector_cost_no_other_pose(sound: Dataset) -> None:
    outliers = np.zeros(len(sound.points), dtype=bool)
    outliers[[0, 30, 60, 90]] = True  # the first reflector of a few poses
    assert len(np.unique(AveragedData.of(sound, outliers).subsampled(0).dataset.points.pose)) == MAX_POSES


def test_seeds_choose_other_poses_and_one_seed_the_same(sound: Dataset) -> None:
    np.testing.assert_array_equal(kept(sound, 1), kept(sound, 1))
    assert len(np.setdiff1d(kept(sound, 1), kept(sound, 2))) > MAX_POSES / 10


def test_every_part_of_a_run_and_of_each_joints_range_is_kept(sound: Dataset) -> None:
    for along in (sound.poses.time_s, *sound.poses.q.T):
        edges = np.quantile(along, np.linspace(0.0, 1.0, 11))
        counts, _ = np.histogram(along[kept(sound)], edges)
        assert counts.min() > 0.6 * MAX_POSES / 10
        assert counts.max() < 1.5 * MAX_POSES / 10


def test_sockets_have_as_many_poses_each_and_rare_ones_all_of_theirs() -> None:
    dataset = simulate(
        find_robot("ur5e"), kind="socket", poses=420, points=6, noise=Noise(joint_rad=1e-5), seed=1
    ).dataset
    rare = np.flatnonzero(dataset.points.number == 0)
    fewer = replace(dataset, points=dataset.points.take(np.setdiff1d(np.arange(len(dataset.points)), rare[10:])))
    _, counts = np.unique(fewer.points.number[chosen_rows(fewer, 0)], return_counts=True)
    assert counts.sum() == MAX_POSES
    assert counts.min() == 10
    assert np.ptp(np.sort(counts)[1:]) <= 1


def test_poses_that_are_all_alike_are_thinned_too(sound: Dataset) -> None:
    q = np.repeat(sound.poses.q[:1], len(sound.poses), axis=0)
    assert len(kept(replace(sound, poses=replace(sound.poses, q=q, time_s=None)))) == MAX_POSES


@pytest.mark.parametrize("effects", [{}, {"backlash__elbow_joint": 0.002}], ids=["none", "one"])
def test_any_thinning_gives_one_answer(effects: dict[str, float]) -> None:
    found = [diagnosis_json(examined(seed, **effects)) for seed in SEEDS]
    assert {one["verdict"] for one in found} == {"explained" if effects else "no_gap"}
    certain = [{kind["class"] for kind in one["classes"] if kind["probability"] > 0.95} for one in found]
    assert certain == [{"transmission"} if effects else set()] * len(SEEDS)


def test_sizes_are_fitted_to_all_poses_and_are_as_sure_as_all_of_them_make_them() -> None:
    (all_poses,) = examined(0, backlash__elbow_joint=0.002).findings
    first = tracked(backlash__elbow_joint=0.002).of_poses(np.arange(700) < MAX_POSES)
    (some,) = examine(first, SUSPECTED, seed=0).findings
    size, of_some = (found.parameters["lost_motion"] for found in (all_poses, some))
    assert size.std == pytest.approx(of_some.std * np.sqrt(MAX_POSES / 700), rel=0.2)
    assert abs(size.value - 0.002) < 3.0 * size.std


def test_the_first_lines_say_how_many_poses_are_used() -> None:
    many, few = examined(0), examine(tracked(20), [], seed=0)
    assert diagnosis_json(many)["poses"] == {"used": MAX_POSES, "all": 700}
    assert f"effects are sought in {MAX_POSES} of 700 poses" in document(many).setting
    assert "sought in" not in document(few).setting
