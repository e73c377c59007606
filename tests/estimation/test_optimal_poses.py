from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.errors import DataError, PlanError
from robolaser.estimation import optimal_poses
from robolaser.estimation.optimal_poses import most_telling, planned
from robolaser.geometry.rigid_motion import apply, from_quaternion, inverse, pose
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import motion
from robolaser.parameters import Parameter
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate
from robolaser.simulation.nominal import IMAGE_PX, facing_outward, scanner

PLACE = {"x": 0.5, "y": 0.0, "z": 0.0, "w": np.pi, "phi": 0.0, "psi": 0.0}


def cell(place: dict[str, float] = PLACE) -> Dataset:
    robot = find_robot("scorbot_er7")
    bracket = facing_outward(robot)
    parameters = scanner(bracket)
    for name, value in place.items():
        unit = "m" if name in "xyz" else "rad"
        parameters[f"target.{name}"] = Parameter(f"target.{name}", unit, value, value - 0.2, value + 0.2)
    return Dataset(
        name="cell", poses=Poses(()), points=Points(np.empty(0, dtype=np.int64), ()), robot=robot,
        parameters=parameters, bracket_quat=bracket, image_px=IMAGE_PX, board=Board(9, 7, 0.010), placed=False,
    )  # fmt: skip


@pytest.fixture(scope="module")
def description() -> Dataset:
    return cell()


@pytest.fixture(scope="module")
def q(description: Dataset) -> Array:
    return planned(description, count=20, seed=1)


def cut(description: Dataset, q: Array, off_m: Array) -> float:
    """Share of postures in whose image the board is cut where it lies so far off."""
    v = {name: np.array([item.nominal]) for name, item in description.parameters.items()}
    shift = np.array([v[f"t_{axis}"][0] for axis in "xyz"])
    T_flange_camera = pose(from_quaternion(np.array(description.bracket_quat)), shift)
    T_base_target = motion(v, "target")[0]
    T_base_target[:3, 3] += off_m
    T = inverse(description.robot.forward(q[None])[0] @ T_flange_camera) @ T_base_target
    corners = np.array([[0, 0, 0], [0.08, 0, 0], [0, 0.06, 0], [0.08, 0.06, 0]])
    x, y, z = np.moveaxis(apply(T[:, None], corners), -1, 0)
    u, w = v["u_0"] - y / z * v["f"] / v["s_u"], v["v_0"] + x / z * v["f"] / v["s_v"]
    return 1.0 - float(((z > 0) & (u > 0) & (u < 639) & (w > 0) & (w < 479)).all(axis=1).mean())


def test_from_every_planned_posture_the_whole_board_is_in_the_image(description: Dataset, q: Array) -> None:
    assert cut(description, q, np.zeros(3)) == 0.0


@pytest.mark.parametrize("direction", np.linspace(0.0, 2 * np.pi, 6, endpoint=False))
def test_a_board_three_centimetres_off_is_cut_in_few_postures(description: Dataset, q: Array, direction: float) -> None:
    assert cut(description, q, 0.03 * np.array([np.cos(direction), np.sin(direction), 0.1])) <= 0.1


def test_planned_postures_lie_within_the_joint_limits(description: Dataset, q: Array) -> None:
    assert ((q > description.robot.lower) & (q < description.robot.upper)).all()


@pytest.fixture
def tries_fewer(monkeypatch: pytest.MonkeyPatch) -> None:
    """Choose among a third of the usual candidates."""
    monkeypatch.setattr(optimal_poses, "MOST_TRIED", 600)


@pytest.mark.usefixtures("tries_fewer")
def test_the_same_seed_plans_the_same_and_others_or_effects_to_be_told_apart_another(description: Dataset) -> None:
    first, same, of_other_seed = (planned(description, count=10, seed=seed) for seed in (1, 1, 2))
    assert (same == first).all()
    assert not (of_other_seed == first).all()
    other = planned(description, count=10, effects=["joint_compliance:joint_2"], seed=1)
    assert {tuple(row) for row in other} != {tuple(row) for row in first}


@pytest.mark.usefixtures("tries_fewer")
def test_where_the_arm_may_not_stand_nothing_is_planned(description: Dataset) -> None:
    q = planned(description, count=10, allowed=lambda q: q[:, 0] > 0.02, seed=1)
    assert (q[:, 0] > 0.02).all()


@pytest.fixture
def gives_up_early(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nothing is found, nothing is found in a tenth of the time."""
    monkeypatch.setattr(optimal_poses, "BATCHES", 6)


@pytest.mark.usefixtures("gives_up_early")
def test_where_limits_keep_the_arm_from_looking_they_are_named(description: Dataset) -> None:
    with pytest.raises(PlanError, match=r"from [1-9]\d* of \d+ configurations.*and 0 of these are allowed.*\[limits\]"):
        planned(description, count=5, allowed=lambda q: q[:, 0] > 9.0, seed=1)


@pytest.mark.usefixtures("tries_fewer")
def test_as_many_postures_are_planned_as_are_asked_for(description: Dataset) -> None:
    assert len(planned(description, count=420, seed=1)) == 420


def test_few_blocks_chosen_by_exchange_are_nearly_the_best_of_all() -> None:
    rng = np.random.default_rng(3)
    shortfall = []
    for _ in range(20):
        slopes = rng.normal(size=(9, 2, 4)) * rng.uniform(0.2, 3.0, (9, 1, 1))

        def worth(chosen: tuple[int, ...], slopes: Array = slopes) -> float:
            some = slopes[list(chosen)].reshape(-1, 4)
            return float(np.linalg.slogdet(np.eye(4) + some.T @ some)[1])

        best = max(worth(some) for some in combinations(range(9), 4))
        shortfall.append(best - worth(tuple(most_telling(slopes, 4).tolist())))
    assert min(shortfall) > -1e-9
    assert np.median(shortfall) == pytest.approx(0, abs=1e-9)
    assert max(shortfall) < 0.1


def test_no_posture_is_chosen_twice() -> None:
    assert sorted(most_telling(np.random.default_rng(1).normal(size=(12, 3, 5)), 12)) == list(range(12))


@pytest.mark.usefixtures("gives_up_early")
def test_a_board_out_of_reach_is_said_to_be() -> None:
    with pytest.raises(PlanError, match=r"from 0 of \d+ configurations"):
        planned(cell({**PLACE, "x": 3.0}), count=5, seed=1)


def test_a_board_whose_place_is_not_said_cannot_be_planned_for(description: Dataset) -> None:
    left = {name: item for name, item in description.parameters.items() if name != "target.x"}
    with pytest.raises(DataError, match=r"lacks target\.x:"):
        planned(replace(description, parameters=left), count=5, seed=1)
    with pytest.raises(DataError, match="board"):
        planned(replace(description, board=None), count=5, seed=1)


@pytest.mark.usefixtures("tries_fewer")
@pytest.mark.parametrize("mount", ["flange", "base"])
def test_a_camera_sees_its_whole_board_from_every_planned_posture(mount: str) -> None:
    made = simulate(
        find_robot("ur5"), kind="camera", poses=6, points=20, options=CellOptions(mount=mount, placed=False), seed=3
    )
    given = {name: Parameter(name, "", value, value - 0.1, value + 0.1) for name, value in made.truth.items()}
    described = replace(made.dataset, parameters=given)
    q = planned(described, count=10, seed=1)
    values = {name: np.array([value]) for name, value in made.truth.items()}
    arm = find_robot("ur5")
    _, good = Model(made.dataset).blocks.sensor.new_poses.seen_from(values, arm.forward(q[None])[0])
    assert good.all()
    assert ((q > arm.lower) & (q < arm.upper)).all()
    assert (planned(described, count=10, seed=1) == q).all()
    lacking = {name: item for name, item in given.items() if name != "hand_eye.x"}
    with pytest.raises(DataError, match=r"lacks hand_eye\.x"):
        planned(replace(described, parameters=lacking), count=10, seed=1)
