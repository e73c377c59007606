"""Planes, steps and spheres are found among strangers, and measured as well as their points allow."""

import numpy as np
import pytest

from robolaser.commands.scan import SIZE
from robolaser.geometry.rigid_motion import exp_so3
from robolaser.scan.ply import VERTEX
from robolaser.scan.quality import measure

STEP, RADIUS = 0.01, 0.018


def scene(rng, *, noise=1e-4, strangers=500, step=STEP, radius=RADIUS):
    """A floor, a block on it and a sphere beside it, somewhere in space, seen from above."""
    floor = np.column_stack([rng.uniform(-0.1, 0.1, (6000, 2)), np.zeros(6000)])
    block = np.column_stack([rng.uniform(0.02, 0.06, (1500, 2)), np.full(1500, step)])
    way = rng.normal(size=(1500, 3))
    way[:, 2] = np.abs(way[:, 2])
    ball = np.array([-0.04, -0.03, radius]) + radius * way / np.linalg.norm(way, axis=1, keepdims=True)
    xyz = np.concatenate([floor, block, ball])
    std = noise * rng.uniform(0.5, 2.0, len(xyz))
    xyz = xyz + std[:, None] * rng.normal(size=xyz.shape)
    xyz = np.concatenate([xyz, rng.uniform(-0.1, 0.1, (strangers, 3))])
    std = np.append(std, np.full(strangers, noise))
    out = np.zeros(len(xyz), VERTEX)
    out["x"], out["y"], out["z"] = (xyz @ exp_so3(rng.normal(scale=0.5, size=3)).T + rng.uniform(-1, 1, 3)).T
    out["std"] = std
    return out[rng.permutation(len(out))]


@pytest.mark.parametrize("seed", range(5))
def test_sizes_are_found_within_their_own_doubt(seed):
    found = measure(scene(np.random.default_rng(seed)), plane=True, step_m=STEP, sphere_m=RADIUS)
    plane, step, sphere = found.primitives
    for body, known in ((step, STEP), (sphere, RADIUS)):
        assert abs(body.size_m - known) < 4 * body.std_m
        assert 0 < body.std_m < 2e-5
        assert body.error_m == pytest.approx(body.size_m - known)
    for body in found.primitives:
        assert body.rms_m == pytest.approx(body.predicted_m, rel=0.15)
    assert plane.points > 5500
    assert step.points > 1300
    assert sphere.points > 1300


def test_a_size_that_differs_from_the_known_one_is_told_not_bent():
    found = measure(scene(np.random.default_rng(7), step=0.0103, radius=0.0185), step_m=STEP, sphere_m=RADIUS)
    np.testing.assert_allclose([body.error_m for body in found.primitives[1:]], [3e-4, 5e-4], atol=3e-5)


def test_clouds_whose_scatter_nobody_knows_are_measured_too():
    vertices = scene(np.random.default_rng(1))
    vertices["std"] = np.nan
    found = measure(vertices, plane=True, step_m=STEP, sphere_m=RADIUS)
    assert abs(found.primitives[2].error_m) < 5e-5
    assert np.isnan(found.scatter_m)


def test_the_same_cloud_gives_the_same_sizes():
    vertices = scene(np.random.default_rng(2))
    one, other = (measure(vertices, sphere_m=RADIUS, seed=5).primitives for _ in range(2))
    assert one == other


@pytest.mark.parametrize(("sizes", "said"), [({"step_m": 0.05}, "50 mm off"), ({"sphere_m": 0.1}, "radius 100 mm")])
def test_what_is_not_there_is_not_found(sizes, said):
    found = measure(scene(np.random.default_rng(3), strangers=0), plane=True, **sizes)
    (missing,) = found.missing
    assert said in str(missing)
    assert [body.what for body in found.primitives] == ["plane"]  # what is there is measured all the same


def test_no_body_is_found_in_a_handful_of_points():
    found = measure(scene(np.random.default_rng(4))[:10], plane=True, step_m=STEP, sphere_m=RADIUS)
    assert not found.primitives
    assert len(found.missing) == 3


@pytest.mark.parametrize("span", [0.0, 0.1], ids=["place", "line"])
def test_no_body_is_found_at_one_place_or_on_one_line(span):
    points = np.zeros(500, VERTEX)
    points["x"] = span * np.linspace(0, 1, len(points))
    points["std"] = 1e-4
    found = measure(points, plane=True, step_m=STEP, sphere_m=RADIUS)
    assert not found.primitives
    assert len(found.missing) == 3


def test_a_point_at_a_spheres_middle_stops_nobody():
    vertices = scene(np.random.default_rng(6), strangers=0)
    vertices = np.append(vertices, vertices[:1])
    vertices["std"][-1] = 1.0
    for axis in "xyz":
        ball = measure(vertices[:-1], sphere_m=RADIUS)
        vertices[axis][-1] = vertices[axis].mean()
    assert len(ball.primitives) == 1
    assert len(measure(vertices, sphere_m=RADIUS).primitives) == 1


@pytest.mark.parametrize("noise", [2e-5, 1e-4])
def test_the_least_step_that_may_be_asked_for_is_found_whatever_the_seed(noise):
    vertices = scene(np.random.default_rng(8), noise=noise, step=SIZE.gte, strangers=200)
    for seed in range(10):
        found = measure(vertices, step_m=SIZE.gte, seed=seed)
        assert abs(found.primitives[1].error_m) < 0.05 * SIZE.gte


@pytest.mark.parametrize(("factor", "said"), [(5.0, "more than noise"), (0.2, "does not fit"), (1.5, ""), (0.7, "")])
def test_a_promise_that_is_far_from_the_scatter_is_told(factor, said):
    vertices = scene(np.random.default_rng(9), strangers=0)
    vertices["std"] *= factor
    found = measure(vertices, plane=True)
    assert len(found.doubts) == bool(said)
    assert said in " ".join(found.doubts)
