"""The calibration with the parameters left out that follow from the others."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from asked import simulate_as_asked
from scipy.optimize import least_squares

from robolaser import compare, save
from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.errors import UsageError
from robolaser.model.forward_model import Model
from robolaser.model.sensors.stripe_similarity import SIMILARITY
from robolaser.parameters import Parameter
from robolaser.problems import ReducedCalibration, ScannerCalibration
from robolaser.robot.by_name import find_robot
from robolaser.simulation import Simulated

CELLS: dict[str, dict[str, Any]] = {
    "stripe": {},
    "stripe along v": {"stripe_axis": "v"},
    "unplaced": {"placed": False},
    "rolled": {"effects": {"laser_roll": 0.05}},
    "rolled, unplaced": {"effects": {"laser_roll": 0.05}, "placed": False},
    "bent arm": {"effects": {"joint_offset:joint_2": 0.01}},
    "bent arm, unplaced": {"effects": {"joint_offset:joint_2": 0.01}, "placed": False},
    "scaled target": {"effects": {"target_scale": 0.01}},
    "tracker": {"kind": "point"},
    "tracker, bent arm": {"kind": "point", "effects": {"joint_offset:joint_2": 0.01}},
    "bodies": {"kind": "pose"},
    "profiles": {"kind": "profile"},
    "sockets": {"kind": "socket"},
    "sockets, bent arm": {"kind": "socket", "effects": {"joint_offset:joint_2": 0.01}},
}
APPROXIMATE: dict[str, dict[str, Any]] = {
    "curved sheet": {"effects": {"laser_curvature": 0.05}},
    "creeping bracket": {"effects": {"hand_eye_drift": 1e-3}},
}


def made_in(cell: dict[str, Any], noise: Noise | None = None) -> Simulated:
    return simulate_as_asked(
        find_robot("scorbot_er7"), poses=12, points=5 if "kind" not in cell else 3, noise=noise, seed=3, **cell
    )


def truth_of(made: Simulated, problem: ReducedCalibration) -> tuple[Array, Array]:
    """The truth as the whole model's candidate with its gauge held, and as the reduced problem's, (1, d) both."""
    whole = problem.model.parameters
    x = problem.model.fix_gauge(np.array([made.truth[name] for name in whole.names]))[None]
    return x, x[:, whole.columns(problem.names)]


def with_bounds(dataset: Dataset, **bounds: tuple[float, float]) -> Dataset:
    given = dict(dataset.parameters)
    for name, (lower, upper) in bounds.items():
        item = given.get(name, Parameter(name, "", lower, lower, upper))
        given[name] = replace(item, nominal=float(np.clip(item.nominal, lower, upper)), lower=lower, upper=upper)
    return replace(dataset, parameters=given)


@pytest.mark.parametrize("cell", list(CELLS))
def test_at_the_truth_of_a_world_without_noise_nothing_is_left(cell: str) -> None:
    made = made_in(CELLS[cell])
    problem = ReducedCalibration(Model(made.dataset, made.effects))
    whole, x = truth_of(made, problem)
    assert problem.model.cost(problem.completed(x))[0] < 1e-16
    np.testing.assert_allclose(problem.completed(x)[0], whole[0], rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("cell", list(APPROXIMATE))
def test_where_points_do_not_grow_with_the_baseline_next_to_nothing_is_left(cell: str) -> None:
    made = made_in(APPROXIMATE[cell])
    problem = ReducedCalibration(Model(made.dataset, made.effects))
    _, x = truth_of(made, problem)
    assert np.sqrt(problem.model.cost(problem.completed(x))[0] / len(made.dataset.points)) < 1e-8


def test_a_scanner_leaves_six_numbers_and_others_none() -> None:
    for cell, left in (({}, 6), ({"placed": False}, 6), ({"kind": "point"}, 0), ({"kind": "socket"}, 0)):
        assert ReducedCalibration(Model(made_in(cell).dataset)).n_var == left


def test_the_focal_length_is_held_and_numbers_of_effects_are_free() -> None:
    made = made_in({"effects": {"laser_roll": 0.05}})
    problem = ReducedCalibration(Model(made.dataset, made.effects))
    assert problem.names == ("s_u", "s_v", "u_0", "v_0", "k", "theta", "laser_roll.laser.angle")
    completed = problem.completed(np.random.default_rng(0).uniform(problem.xl, problem.xu, (5, problem.n_var)))
    np.testing.assert_array_equal(completed[:, 0], made.dataset.parameters["f"].nominal)


NOISY = Noise(pixel_px=0.3, joint_rad=1e-4)


WIDE = (
    {"b": (1e-3, 10.0)}
    | dict.fromkeys(("w", "phi", "psi"), (-np.pi, np.pi))
    | dict.fromkeys(("t_x", "t_y", "t_z"), (-9.0, 9.0))
)


@pytest.mark.parametrize("cell", ["stripe", "stripe along v", "rolled", "bent arm", "scaled target"])
@pytest.mark.parametrize("angles", ["xyz", "zyz"])
def test_scipy_finds_nothing_lower_where_no_bound_is_in_the_way(cell: str, angles: str) -> None:
    rng = np.random.default_rng(2)
    made = made_in(CELLS[cell], NOISY)
    problem = ReducedCalibration(Model(replace(with_bounds(made.dataset, **WIDE), angles=angles), made.effects))
    model, whole = problem.model, problem.model.parameters
    columns = whole.columns(SIMILARITY)
    nominal = whole.nominal[whole.columns(problem.names)]
    near = nominal + 0.1 * rng.uniform(-1, 1, (3, problem.n_var)) * (problem.xu - problem.xl)
    for best in problem.completed(np.clip(near, problem.xl, problem.xu)):

        def left(z: Array, best: Array = best) -> Array:
            x = best.copy()
            x[columns] = z
            return model.residuals(x[None])[0].ravel()

        theirs = least_squares(left, best[columns], xtol=1e-15, ftol=1e-15, gtol=1e-15)
        assert model.cost(best[None])[0] <= 2 * theirs.cost * (1 + 1e-7)


@pytest.mark.parametrize("cell", list(CELLS))
def test_all_that_is_completed_lies_within_the_bounds(cell: str) -> None:
    made = made_in(CELLS[cell], None if "kind" in CELLS[cell] else NOISY)
    problem = ReducedCalibration(Model(made.dataset, made.effects))
    whole = problem.model.parameters
    completed = problem.completed(np.random.default_rng(5).uniform(problem.xl, problem.xu, (20, problem.n_var)))
    assert ((completed >= whole.lower) & (completed <= whole.upper)).all()


@pytest.mark.parametrize("placed", [True, False])
def test_a_laser_may_sit_on_the_other_side(placed: bool) -> None:
    """Points on a flat sheet, seen through minus the baseline, are the same after half a turn about its normal."""
    made = made_in({"placed": placed})
    b = made.truth["b"]
    free = with_bounds(made.dataset, b=(-2 * b, 2 * b), t_x=(-1.0, 1.0), t_y=(-1.0, 1.0), t_z=(-1.0, 1.0))
    problem = ReducedCalibration(Model(free))
    _, x = truth_of(made, problem)
    assert problem.model.cost(problem.completed(x))[0] < 1e-16
    other = ReducedCalibration(Model(replace(free, bracket_quat=_turned_about_the_sheets_normal(made))))
    completed = other.completed(x)
    assert other.model.cost(completed)[0] < 1e-14
    assert completed[0, other.model.parameters.columns(["b"])[0]] < 0


def _turned_about_the_sheets_normal(made: Simulated) -> tuple[float, float, float, float]:
    from scipy.spatial.transform import Rotation  # noqa: PLC0415

    theta = made.truth["theta"]
    half = Rotation.from_rotvec(np.pi * np.array([np.cos(theta), 0.0, np.sin(theta)]))
    bracket = Rotation.from_quat(made.dataset.bracket_quat)
    small = Rotation.from_euler("XYZ", [made.truth[name] for name in ("w", "phi", "psi")])
    return tuple((bracket * small * half * small.inv()).as_quat().tolist())


@pytest.mark.parametrize(("name", "off"), [("b", 0.01), ("t_x", 0.01), ("phi", -0.02), ("psi", 0.02)])
def test_a_bound_that_shuts_the_truth_out_is_where_the_parameter_ends(name: str, off: float) -> None:
    made = made_in({}, NOISY)
    ends = sorted((made.truth[name] + off, made.truth[name] + 5 * off))
    problem = ReducedCalibration(Model(with_bounds(made.dataset, **{name: (ends[0], ends[1])})))
    _, x = truth_of(made, problem)
    at = problem.model.parameters.columns([name])
    assert problem.completed(x)[0, at] == made.truth[name] + off


@pytest.mark.parametrize("cell", ["stripe", "unplaced", "tracker, bent arm", "sockets, bent arm"])
def test_a_population_is_completed_as_its_members_are(cell: str) -> None:
    made = made_in(CELLS[cell])
    problem = ReducedCalibration(Model(made.dataset, made.effects))
    x = np.random.default_rng(1).uniform(problem.xl, problem.xu, (12, problem.n_var))
    alone = np.concatenate([problem.completed(x[i : i + 1]) for i in range(len(x))])
    cost = problem.model.cost
    np.testing.assert_allclose(cost(problem.completed(x)), cost(alone), rtol=1e-9)


@pytest.mark.parametrize("placed", [True, False])
def test_poles_cost_infinitely_and_are_completed_within_the_bounds(placed: bool) -> None:
    made = made_in({"placed": placed})
    problem = ReducedCalibration(Model(with_bounds(made.dataset, v_0=(0.0, 480.0))))
    whole = problem.model.parameters
    x = np.tile(whole.nominal[whole.columns(problem.names)], (2, 1))
    pole = dict(zip(problem.names, range(problem.n_var), strict=True))
    x[1, pole["theta"]], x[1, pole["v_0"]] = 0.0, made.dataset.points.pixel[0, 1]
    completed = problem.completed(x)
    assert ((completed >= whole.lower) & (completed <= whole.upper)).all()
    out: dict[str, Array] = {}
    problem._evaluate(x, out)
    assert np.isfinite(out["F"][0, 0])
    assert np.isinf(out["F"][1, 0])


def test_a_data_set_asks_the_same_in_memory_and_in_its_folder(tmp_path):
    dataset, other = (replace(made_in(cell).dataset, name="cell") for cell in (CELLS["tracker"], CELLS["bodies"]))
    folder = tmp_path / "cell"
    save(dataset, folder)
    asked = [ScannerCalibration(given) for given in (dataset, folder, str(folder))]
    costs = [problem.evaluate(problem.xl[None]).item() for problem in asked]
    assert costs == [costs[0]] * 3
    given = {"data": dataset, "folder": folder, "text": str(folder)}
    assert compare(given, ["de"], seeds=1, budget=60, jobs=1).to_frame()["best"].nunique() == 1
    with pytest.raises(UsageError, match=r"are called 'cell'"):
        compare([dataset, other], ["de"], seeds=1, budget=60)
