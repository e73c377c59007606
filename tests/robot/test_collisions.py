"""Bodies of an arm against one another and against what stands about it."""

from itertools import pairwise

import numpy as np
import pytest

from robolaser.geometry.rigid_motion import apply, pose
from robolaser.robot.by_name import find_robot
from robolaser.robot.collision_bodies import Body, carried_bodies, link_bodies
from robolaser.robot.collisions import CollisionModel
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import random_configurations

ARM = find_robot("scorbot_er7")
EYE = np.eye(4)
LINK = """<link name="{0}"><collision><origin xyz="0 0 0.15"/><geometry>{1}</geometry></collision></link>"""
JOINT = """<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin xyz="0 0 0.3"/>
<axis xyz="0 1 0"/><limit lower="-3.2" upper="3.2"/></joint>"""
BOX, ROD, BALL = '<box size="0.1 0.1 0.3"/>', '<cylinder radius="0.05" length="0.3"/>', '<sphere radius="0.1"/>'
MESH = '<mesh filename="package://nowhere/link.stl"/>'


def folding(*shapes: str) -> Robot:
    """Links of 0.3 m, one on the other, each turning about y."""
    names = "abcdef"[: len(shapes)]
    links = "".join(LINK.format(*pair) for pair in zip(names, shapes, strict=True))
    joints = "".join(JOINT.format(f"j{b}", a, b) for a, b in pairwise(names))
    return Robot.from_urdf(f"<robot name='folding'>{links}{joints}</robot>", flange=names[-1])


def between(model: CollisionModel, one: str, other: str) -> list[int]:
    return [k for k, pair in enumerate(model.pairs) if model.name(pair) in {f"{one} and {other}", f"{other} and {one}"}]


def segments_apart(a: np.ndarray, b: np.ndarray) -> float:
    """Least distance of two straight lines' points, by trying many."""
    s = np.linspace(0, 1, 150)[:, None]
    one, other = a[0] + s * (a[1] - a[0]), b[0] + s * (b[1] - b[0])
    return float(np.linalg.norm(one[:, None] - other[None], axis=-1).min())


def test_the_gap_of_two_links_is_that_of_their_centre_lines_less_their_radii() -> None:
    radius = 0.02
    model = CollisionModel(ARM, link_bodies(ARM, radius))
    q = random_configurations(ARM, 20, np.random.default_rng(3))
    assert between(model, "link_2", "link_5")
    for row, gaps in zip(q, model.gaps(q), strict=True):
        T = model.placements(row)
        ends = [T[n, :3, 3] + np.outer([-0.5, 0.5], T[n, :3, 2]) * body.size[1] for n, body in enumerate(model.bodies)]
        for (i, j), gap in zip(model.pairs, gaps, strict=True):
            assert gap == pytest.approx(segments_apart(ends[i], ends[j]) - 2 * radius, abs=2e-3)


def test_bodies_move_as_the_arm_does() -> None:
    probe = Body("probe", ARM.flange, "sphere", (0.01,), EYE)
    model = CollisionModel(ARM, [*link_bodies(ARM), probe])
    for q in random_configurations(ARM, 5, np.random.default_rng(1)):
        np.testing.assert_allclose(model.placements(q)[-1], ARM.forward(q[None, None])[0, 0], atol=1e-12)


@pytest.mark.parametrize("shapes", [(BOX,) * 5, (ROD,) * 5, (MESH,) * 5, (BOX, MESH, ROD, MESH, BALL)])
def test_an_arm_folded_onto_itself_hits_itself_and_a_straight_one_does_not(shapes: tuple[str, ...]) -> None:
    arm = folding(*shapes)
    model = CollisionModel(arm, link_bodies(arm))
    folded = np.array([0.0, 2.6, 2.6, 0.0])  # a triangle whose last side goes back through the first
    assert model.clear(np.zeros((1, 4))).all()
    assert not model.clear(folded[None]).any()


def test_simple_shapes_of_a_urdf_are_taken_and_meshes_are_capsules() -> None:
    kinds = {body.link: body.kind for body in link_bodies(folding(BOX, MESH, ROD, BALL))}
    assert kinds == {"a": "box", "b": "capsule", "c": "cylinder", "d": "sphere"}
    unread = folding('<sphere radius="${r}"/>', '<box size="1 -1 1"/>', BOX)
    assert {body.link: body.kind for body in link_bodies(unread)} == {"a": "capsule", "b": "capsule", "c": "box"}


@pytest.mark.parametrize("name", ["ur5e", "kr6", "iiwa7", "xarm7", "so101", "scorbot_er7"])
def test_most_of_an_arms_range_is_free_of_itself(name: str) -> None:
    """Published arms rarely hit themselves: capsules that said so often would forbid what everybody does."""
    arm = find_robot(name)
    q = random_configurations(arm, 200, np.random.default_rng(1))
    assert CollisionModel(arm, link_bodies(arm)).clear(q).mean() > 0.75


def test_the_sensor_and_boxes_can_be_hit_by_any_link_but_their_own() -> None:
    sensor = carried_bodies("sensor", ARM, np.array([[0.07, 0.0, -0.065]]), 0.02)
    table = Body("table", "base_link", "box", (2.0, 2.0, 0.1), pose(np.eye(3), np.array([0.0, 0.0, -0.3])))
    model = CollisionModel(ARM, [*link_bodies(ARM, 0.02), *sensor, table])
    assert between(model, "sensor", "table")
    assert between(model, "sensor", "link_2")
    assert not between(model, "sensor", "link_5")
    assert not model.unchecked
    q = random_configurations(ARM, 200, np.random.default_rng(1))
    tip = apply(ARM.forward(q[None])[0], np.array([[0.07, 0.0, -0.065]] * len(q)))[:, 2]
    (k,) = between(model, "sensor", "table")
    assert (model.gaps(q)[tip < -0.25, k] < 0).all()
    assert (tip < -0.25).any()


def test_what_overlaps_everywhere_is_named_and_not_checked() -> None:
    everywhere = Body("hall", "base_link", "box", (9.0, 9.0, 9.0), EYE)
    model = CollisionModel(ARM, [*link_bodies(ARM), everywhere])
    assert "link_3 and hall" in map(model.name, model.unchecked)
    assert not between(model, "link_3", "hall")
