"""Start values of a tracker are found whatever the frames, and all of its reflectors, however many."""

import numpy as np
import pytest

from robolaser import calibrate
from robolaser.data.stated_noise import Noise
from robolaser.geometry.rigid_motion import apply, exp_so3, pose
from robolaser.model.sensors.tracker_fit import base_and_tools
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


def seen(rng: np.random.Generator, *, poses: int, tools: int, turn: float = 2.0, noise: float = 0.0):
    T = pose(exp_so3(rng.normal(0, turn, (poses, 3))), rng.normal(0, 0.5, (poses, 3))).repeat(tools, axis=0)
    places = rng.normal(0, 0.1, (tools, 3))
    T_world_base = pose(exp_so3(rng.normal(0, 2, 3)), rng.normal(0, 3, 3))
    tool = np.tile(np.arange(tools), poses)
    measured = apply(T_world_base, apply(T, places[tool]))
    return measured + noise * rng.normal(size=measured.shape), T, tool, T_world_base, places


@pytest.mark.parametrize("tools", [1, 2, 3, 6])
@pytest.mark.parametrize("seed", range(5))
def test_exact_points_give_the_frames_back(seed, tools):
    measured, T, tool, T_world_base, places = seen(np.random.default_rng(seed), poses=10, tools=tools)
    R, shift, found = base_and_tools(measured[None], T[None], tool)
    np.testing.assert_allclose(pose(R, shift)[0], T_world_base, atol=1e-8)
    np.testing.assert_allclose(found[0], places, atol=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_few_noisy_poses_that_hardly_turn_end_at_a_stationary_point(seed):
    measured, T, tool, *_ = seen(np.random.default_rng(seed), poses=5, tools=3, turn=0.05, noise=1e-3)
    R, shift, places = base_and_tools(measured[None], T[None], tool)

    def cost(R, shift, places):
        return np.square(apply(pose(R, shift), apply(T, places[tool])) - measured).sum()

    least = cost(R[0], shift[0], places[0])
    for axis in np.concatenate([np.eye(3), -np.eye(3)]):
        moved = exp_so3(1e-4 * axis) @ R[0]
        middle = apply(T, places[0][tool]).mean(axis=0)
        assert cost(moved, shift[0] + R[0] @ middle - moved @ middle, places[0]) >= least
        assert cost(R[0], shift[0] + 1e-4 * axis, places[0]) >= least


def test_candidates_are_fitted_side_by_side():
    measured, T, tool, *_ = seen(np.random.default_rng(7), poses=8, tools=2, noise=1e-3)
    flanges = np.stack([T, pose(exp_so3(np.array([0.01, 0.0, 0.0])), np.zeros(3)) @ T])
    together = base_and_tools(measured[None], flanges, tool)
    for i, one in enumerate(flanges):
        for all_of_them, alone in zip(together, base_and_tools(measured[None], one[None], tool), strict=True):
            np.testing.assert_allclose(all_of_them[i], alone[0], atol=1e-9)


@pytest.mark.parametrize("reflectors", [1, 4, 9])
def test_every_reflector_of_a_tracker_is_calibrated(reflectors: int) -> None:
    made = simulate(
        find_robot("scorbot_er7"), kind="point", poses=60, points=reflectors, noise=Noise(point_m=1e-5), seed=3
    )
    found = calibrate(made.dataset).calibration
    assert len(found.x) == 6 + 3 * reflectors
    truth = np.array([made.truth[name] for name in found.model.parameters.names])
    places = [i for i, name in enumerate(found.model.parameters.names) if name.startswith("tool.")]
    np.testing.assert_allclose(found.x[places], truth[places], atol=3e-5)
