"""Worlds of chance: repeatable, sealed against reading, and as their kind says."""

import json
from dataclasses import replace

import numpy as np
import pytest
from several import two_trackers

import robolaser
from robolaser.data.sessions import Sessions
from robolaser.data.stated_noise import Noise
from robolaser.errors import TrialError
from robolaser.robot.by_name import find_robot
from robolaser.trials.building import Ranges
from robolaser.trials.detectability import Detectability
from robolaser.trials.kinds import KINDS
from robolaser.trials.making import STANDING_OUT, WRONGLY, make
from robolaser.trials.resampling import reference_of, stepped
from robolaser.trials.synthetic.fault_models import FAULT_MODELS, OUTLIERS, UNMODELLED
from robolaser.trials.synthetic.fault_models.joints import PoseScatter
from robolaser.trials.trial import deal

SMALL = Ranges(poses=(10, 12), points=(5, 6), pixel_px=(0.1, 0.1))


@pytest.fixture(scope="module")
def worlds():
    robot = find_robot("scorbot_er7")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Detectability, "rivals", lambda *_: [])  # of each fault, which take longer than all the rest
        return {kind: make(robot, kind, seed=8, ranges=SMALL) for kind in KINDS if kind != "physics"}


def test_kinds_hold_what_they_say(worlds):
    named = {kind: [effect for effect, _ in world.truth["effects"]] for kind, world in worlds.items()}
    assert named["none"] == []
    assert named["outliers"] == [OUTLIERS]
    assert 3 <= len(named["several"]) <= 4
    for kind in ("repeatability", "misstated_noise", "shared_noise", "growing_noise"):
        assert len(named[kind]) <= 1
    assert len(named["small_errors"]) == 1
    assert worlds["small_errors"].truth["each"][0]["misfit"] > STANDING_OUT
    assert set(named["unknown"]) & set(UNMODELLED)
    for kind, number in (("single", 1), ("pair", 2), ("triple", 3)):
        known = [name for name in named[kind] if name != OUTLIERS]
        assert len(known) == number
        assert not set(known) & set(UNMODELLED)


def test_what_is_not_ideal_is_in_the_truth_and_not_in_the_data_set(worlds):
    truths = {kind: world.truth for kind, world in worlds.items()}
    assert truths["repeatability"]["noise"]["repeatability_m"] >= 2e-5
    assert truths["shared_noise"]["noise"]["image_px"] > 0.0
    assert truths["misstated_noise"]["noise_stated"] in WRONGLY
    assert truths["growing_noise"]["noise"]["growth"] >= 2.0
    assert truths["none"]["background"] == []
    assert len(truths["small_errors"]["background"]) > len(find_robot("scorbot_er7").joints)
    assert worlds["repeatability"].dataset.noise.joint_rad is None


def test_noise_that_is_stated_wrongly_is_off_by_the_factor_of_the_truth(worlds):
    world = worlds["misstated_noise"]
    true, stated = world.truth["noise"], world.dataset.noise
    assert stated.pixel_px / true["pixel_px"] == pytest.approx(world.truth["noise_stated"])
    assert stated.target_m / true["target_m"] == pytest.approx(world.truth["noise_stated"])


def test_an_image_that_is_off_is_off_as_a_whole(built):
    rng = np.random.default_rng(3)
    off = replace(built, image_px=5.0, noise=Noise()).read((), rng).points
    shift = off.pixel - built.exact(()).points.pixel[np.repeat(np.arange(len(off) // 2), 2)]
    images = off.pose * 2 + off.repeat
    within = [np.ptp(shift[images == image], axis=0).max() for image in np.unique(images)]
    assert max(within) < 1e-9
    assert np.std(shift) == pytest.approx(5.0, rel=0.4)


def test_noise_that_grows_is_larger_where_the_target_is_farther_and_as_large_on_average(built):
    rng, clean = np.random.default_rng(3), built.exact(()).points
    noisy = replace(built, growth=4.0, repeats=60, noise=Noise(pixel_px=0.1)).read((), rng).points
    off = (noisy.pixel - clean.pixel[np.repeat(np.arange(len(clean)), 60)]).reshape(len(clean), -1)
    camera = (built.cell.run.robot.forward(built.cell.run.q) @ built.cell.eye.mount)[clean.pose, :3, 3]
    away = np.linalg.norm(clean.xyz - camera, axis=1)
    assert np.corrcoef(off.std(axis=1), away**4)[0, 1] > 0.8
    assert off.std() == pytest.approx(0.1, rel=0.05)


def test_an_arm_repeats_as_well_as_the_truth_says(built):
    run, rng = built.cell.run, np.random.default_rng(3)
    scatter = PoseScatter.sample("arm", 1e-4, run, rng)
    off = run.robot.forward(scatter.joints(run.q, run))[:, :3, 3] - run.robot.forward(run.q)[:, :3, 3]
    assert np.sqrt(np.square(off).sum(axis=1).mean()) == pytest.approx(1e-4, rel=0.4)


def test_a_fault_alone_is_a_kind_of_its_own():
    world = make(find_robot("scorbot_er7"), "slipping", seed=2, ranges=SMALL)
    assert [effect for effect, _ in world.truth["effects"]] == ["slipping"]


def test_no_data_set_gives_away_what_it_hides(worlds, tmp_path):
    for kind, world in worlds.items():
        robolaser.save(world.dataset, tmp_path / kind)
        text = (tmp_path / kind / "dataset.toml").read_text() + (tmp_path / kind / "poses.csv").read_text()
        assert not [effect for effect in FAULT_MODELS if effect in text]


def test_the_package_reads_what_was_made_without_a_warning(worlds, tmp_path):
    for kind, world in worlds.items():
        robolaser.save(world.dataset, tmp_path / kind)
        assert robolaser.load(tmp_path / kind).warnings == ()


def test_truth_is_plain_json(worlds):
    for world in worlds.values():
        assert json.loads(json.dumps(world.truth, allow_nan=False)).keys() == world.truth.keys()


def test_a_world_like_a_data_set_keeps_its_poses_and_its_noise(worlds):
    model = worlds["none"].dataset
    like = make(reference_of(model, seed=1), "outliers", seed=3)
    np.testing.assert_array_equal(like.dataset.poses.q, model.poses.q)
    assert like.dataset.noise.target_m == model.noise.target_m
    assert like.truth["robot"] == model.robot.name
    drawn = {name: item.nominal for name, item in model.parameters.items()}
    assert set(like.truth["parameters"]) == set(drawn)


@pytest.mark.parametrize("count", [1, 7, 40])
def test_kinds_are_dealt_in_their_shares(count):
    dealt = deal({"none": 1.0, "single": 3.0}, count, np.random.default_rng(1))
    assert len(dealt) == count
    assert abs(dealt.count("single") - 0.75 * count) < 1


def test_steps_of_a_tilted_target_are_found_to_the_last_digit():
    rng = np.random.default_rng(6)
    turn = np.linalg.qr(rng.normal(size=(3, 3)) * 0.05 + np.eye(3))[0]
    flat = np.column_stack([rng.uniform(-0.3, 0.3, (200, 2)), rng.choice([0.0, 0.03, 0.06], 200)])
    xyz = flat @ turn.T + [0.5, 0.1, 0.0]
    target, level = stepped(xyz, np.array([0.5, 0.1, 1.0]))
    np.testing.assert_allclose(target.inside(xyz)[:, 2], level, atol=1e-12)
    np.testing.assert_allclose(np.unique((level - level.min()).round(9)), [0.0, 0.03, 0.06])
    assert np.linalg.det(target.axes) == pytest.approx(1.0)


def test_several_sensors_and_a_trackers_sessions_are_not_imitated():
    both = two_trackers(8)
    one = replace(both, members=())
    poses = replace(one.poses, session=("monday",) * 4 + ("friday",) * 4)
    apart = replace(one, poses=poses, sessions=Sessions(("monday", "friday")))
    for dataset in (both, apart):
        with pytest.raises(TrialError, match="it has several sensors, or sessions of a tracker"):
            reference_of(dataset, seed=1)
