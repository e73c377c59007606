"""Worlds of chance: repeatable, sealed against reading, and as their kind says."""

import json

import numpy as np
import pytest

import robolaser
from robolaser.geometry.robots import find_robot
from robolaser.trials.building import Ranges
from robolaser.trials.making import KINDS, make
from robolaser.trials.resampling import reference_of, stepped
from robolaser.trials.synthetic.fault_models import FAULT_MODELS, OUTLIERS, UNMODELLED
from robolaser.trials.trial import deal

SMALL = Ranges(poses=(10, 12), points=(5, 6), pixel_px=(0.1, 0.1))


@pytest.fixture(scope="module")
def worlds():
    robot = find_robot("scorbot_er7")
    return {kind: make(robot, kind, seed=8, ranges=SMALL) for kind in KINDS}


def test_the_same_seed_makes_the_same_world_to_the_bit(worlds):
    again = make(find_robot("scorbot_er7"), "outliers", seed=8, ranges=SMALL)
    np.testing.assert_array_equal(again.dataset.points.pixel, worlds["outliers"].dataset.points.pixel)
    assert again.truth == worlds["outliers"].truth


def test_another_seed_makes_another(worlds):
    other = make(find_robot("scorbot_er7"), "none", seed=9, ranges=SMALL)
    assert other.truth["parameters"] != worlds["none"].truth["parameters"]


def test_kinds_hold_what_they_say(worlds):
    named = {kind: [effect for effect, _ in world.truth["effects"]] for kind, world in worlds.items()}
    assert named["none"] == []
    assert named["outliers"] == [OUTLIERS]
    assert set(named["unknown"]) & set(UNMODELLED)
    for kind, number in (("single", 1), ("pair", 2), ("triple", 3)):
        known = [name for name in named[kind] if name != OUTLIERS]
        assert len(known) == number
        assert not set(known) & set(UNMODELLED)


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
        assert json.loads(json.dumps(world.truth)) == json.loads(json.dumps(world.truth, sort_keys=True))


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
