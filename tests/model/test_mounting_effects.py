from dataclasses import replace

import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose
from robolaser.model.effects.base_drift import BaseDrift
from robolaser.model.effects.base_shift import BaseShift
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.hand_eye_drift import HandEyeDrift
from robolaser.model.effects.mount_shift import MountShift
from robolaser.model.effects.requirements import NO_ORDER
from robolaser.model.effects.thermal_state import crept
from robolaser.model.effects.tool_drift import ToolDrift
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return simulate(find_robot("scorbot_er7"), poses=12, points=3, seed=3).dataset


def through(model: Model, stage: Stage, value: Array, **numbers: float) -> Array:
    """What comes out of a stage of a model with one effect."""
    values = {item.name: np.array([item.nominal]) for item in model.effect_parameters.items}
    values |= {model.effects[0].key(name): np.array([number]) for name, number in numbers.items()}
    return model.perturb(values)(stage, value)


def test_a_knocked_base_moves_the_later_poses_and_no_others(dataset):
    model = Model(dataset, (CandidateEffect(BaseShift, "base"),))
    T = dataset.flange()[None]
    moved = through(model, Stage.FLANGE, T, x=1e-3, turn_z=2e-3, moment=0.6)[0]
    before = model.run.progress < 0.6
    assert 3 <= before.sum() <= 9
    np.testing.assert_array_equal(moved[before], T[0, before])
    motion = moved[~before] @ inverse(T[0, ~before])
    np.testing.assert_allclose(motion, motion[:1].repeat(len(motion), axis=0), atol=1e-15)
    np.testing.assert_allclose(motion[0, :3, :3], exp_so3(np.array([0, 0, 2e-3])), atol=1e-15)


def test_a_slipped_mount_moves_all_later_poses_alike_in_the_flange_frame(dataset):
    model = Model(dataset, (CandidateEffect(MountShift, "hand_eye"),))
    T = dataset.flange()[None]
    moved = through(model, Stage.FLANGE, T, x=1e-3, turn_z=2e-3, moment=0.6)[0]
    before = model.run.progress < 0.6
    np.testing.assert_array_equal(moved[before], T[0, before])
    motion = inverse(T[0, ~before]) @ moved[~before]
    expected = pose(exp_so3(np.array([0, 0, 2e-3])), np.array([1e-3, 0, 0]))
    np.testing.assert_allclose(motion, np.tile(expected, (len(motion), 1, 1)), atol=1e-15)


@pytest.mark.parametrize(("kind", "where"), [("stripe", "hand_eye"), ("camera", "hand_eye"), ("point", "tool")])
def test_a_mount_that_slips_is_the_sensors_bracket_or_the_tool(kind, where):
    small = simulate(find_robot("ur5"), kind=kind, poses=8, points=6, seed=3).dataset
    assert MountShift.locations(small) == (where,)
    assert bool(ToolDrift.locations(small)) == bool(BaseDrift.locations(small)) == (where == "tool")


def test_a_drift_cannot_be_tested_where_a_joint_only_turns_one_way():
    made = simulate(find_robot("ur5"), kind="point", poses=12, points=2, seed=3).dataset
    assert ToolDrift.missing(made) == BaseDrift.missing(made) == ""
    one_way = replace(made, poses=replace(made.poses, time_s=-made.poses.q[:, 2]))
    for effect in (ToolDrift, BaseDrift):
        assert effect.missing(one_way).startswith("elbow_joint moves one way")
        assert effect.missing(replace(made, poses=replace(made.poses, time_s=None))) == NO_ORDER


def test_a_turn_of_the_base_leaves_the_middle_of_all_flanges_in_place(dataset):
    model = Model(dataset, (CandidateEffect(BaseShift, "base"),))
    T = dataset.flange()[None]
    moved = through(model, Stage.FLANGE, T, turn_x=0.02, turn_y=-0.03, moment=0.5)[0]
    motion = (moved @ inverse(T[0]))[(model.run.progress > 0.5)][0]
    middle = T[0, :, :3, 3].mean(axis=0)
    np.testing.assert_allclose(motion[:3, :3] @ middle + motion[:3, 3], middle, atol=1e-15)


def test_every_pause_that_leaves_three_poses_on_either_side_is_tried_as_the_moment(dataset):
    splits = (np.sort(Model(dataset).run.progress)[None] > BaseShift.grid(dataset, "base")).sum(axis=1)
    assert list(splits) == list(range(9, 2, -1))


def test_with_five_poses_no_moment_can_be_found():
    few = simulate(find_robot("scorbot_er7"), poses=5, points=3, seed=3).dataset
    assert BaseShift.missing(few) == "fewer than 6 poses"
    assert BaseShift.locations(few) == ()


def test_creep_starts_with_the_run_and_is_whole_at_its_end():
    progress = np.linspace(0, 1, 21)
    shares = crept(progress, np.array([0.0, 1e-9, 3.0, 8.0]))
    np.testing.assert_allclose(shares[:, [0, -1]], [[0, 1]] * 4, atol=1e-15)
    np.testing.assert_allclose(shares[1], progress, atol=1e-8)
    assert (np.diff(shares) > 0).all()
    assert (shares[2:, 1:-1] > progress[1:-1]).all()


def test_a_base_that_creeps_turns_about_the_middle_of_all_flanges_the_same_as_one_that_was_moved(dataset):
    T = dataset.flange()[None]
    crept_, shifted = (
        through(Model(dataset, (CandidateEffect(effect, "base"),)), Stage.FLANGE, T, x=1e-3, turn_y=0.02, **more)[0]
        for effect, more in ((BaseDrift, {}), (BaseShift, {"moment": 0.5}))
    )
    first, last = np.argsort(Model(dataset).run.progress)[[0, -1]]
    np.testing.assert_allclose(crept_[first], T[0, first], atol=1e-15)
    np.testing.assert_allclose(crept_[last], shifted[last], atol=1e-15)


def test_a_turning_camera_keeps_its_optical_centre(dataset):
    model = Model(dataset, (CandidateEffect(HandEyeDrift, "hand_eye"),))
    T = np.eye(4)[None, None]
    turned = through(model, Stage.MOUNT, T, turn_y=0.01)[0]
    np.testing.assert_array_equal(turned[:, :3, 3], 0)
    last = np.argmax(model.run.progress)
    np.testing.assert_allclose(turned[last, :3, :3], exp_so3(np.array([0, 0.01, 0])), atol=1e-15)
    shifted = through(model, Stage.MOUNT, T, z=1e-3)[0]
    np.testing.assert_allclose(shifted[:, 2, 3], 1e-3 * model.run.progress, atol=1e-18)


def test_a_bracket_may_slip_in_the_pause_between_two_sessions():
    cell = simulate(find_robot("ur5e"), kind="point", poses=16, options=CellOptions(sessions=2), seed=1).dataset
    later = cell.session_of_pose == max(cell.session_of_pose)
    run = Model(cell).run
    (pause,) = {
        moment for (moment,) in MountShift.grid(cell, "tool") if ((run.progress_of_all > moment) == later).all()
    }
    assert run.progress_of_all[~later].max() < pause < run.progress_of_all[later].min()
