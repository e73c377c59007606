"""Errors by session, sensor, point and image: the odd ones are named, and chance is not called odd."""

from dataclasses import replace

import numpy as np
import pytest
from calibrated import POSES, ROWS, point, stripe

from robolaser.data.sessions import Sessions
from robolaser.report.error_groups import group_blocks, groups, sentence


def noise(rows, seed=0):
    return np.random.default_rng(seed).normal(scale=1e-4, size=(rows, 3))


def test_a_pose_that_errs_far_more_than_the_others_is_named():
    dataset = stripe().model.dataset
    errors = noise(POSES * ROWS)
    errors[dataset.points.pose == 5] *= 8
    assert [one.name for one in groups(dataset, [errors]) if one.is_odd] == ["p5"]
    assert sentence(groups(dataset, [errors])).startswith("Large errors: pose p5 has an error of ")


@pytest.mark.parametrize("seed", range(20))
def test_noise_alone_makes_nothing_odd(seed):
    assert not any(one.is_odd for one in groups(stripe().model.dataset, [noise(POSES * ROWS, seed)]))


def test_reflectors_and_sessions_are_groups_of_their_own():
    dataset = point(names=("A", "B", "C")).model.dataset
    sessions = ("monday", "tuesday")
    dataset = replace(
        dataset,
        poses=replace(dataset.poses, session=tuple(sessions[i // 4] for i in range(POSES))),
        sessions=Sessions(sessions, ()),
    )
    errors = noise(3 * POSES)
    errors[dataset.points.number == 1] *= 20
    found = groups(dataset, [errors])
    assert {(one.kind, one.name) for one in found if one.kind != "pose"} == {
        ("session", "monday"), ("session", "tuesday"), ("reflector", "A"), ("reflector", "B"), ("reflector", "C")
    }  # fmt: skip
    assert [one.name for one in found if one.is_odd] == ["B"]


def test_the_table_has_the_error_of_each_series_and_the_odd_ones_first():
    dataset = stripe().model.dataset
    errors = noise(POSES * ROWS)
    errors[dataset.points.pose == 5] *= 8
    _, table = group_blocks(dataset, {"fitted": errors, "held out": 2 * errors})
    first = table.cells[0]
    assert (first[0].text, first[0].note) == ("p5", "odd")
    assert first[4].order == pytest.approx(2 * first[3].order)
