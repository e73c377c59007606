"""The paper's chain: its frames, its gauge, its poles, its limit cases."""

from dataclasses import replace

import numpy as np
import pytest
from cells import on_flange_poses, project

from robolaser.arrays import Array
from robolaser.data.stated_noise import Noise
from robolaser.errors import DataError
from robolaser.geometry.camera import intersect, laser_plane, metric, rays, undistort
from robolaser.geometry.rigid_motion import apply, from_angles, from_quaternion, pose
from robolaser.model.forward_model import Model
from robolaser.parameters import Values
from robolaser.robot.by_name import find_robot
from robolaser.simulation import Simulated, simulate

SEED = 7
RNG = np.random.default_rng(SEED)


@pytest.fixture(autouse=True)
def same_draws_in_any_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "RNG", np.random.default_rng(SEED))


@pytest.fixture(scope="module")
def made() -> Simulated:
    return simulate(find_robot("scorbot_er7"), poses=6, points=5, noise=Noise(), seed=2)


def truth_of(made: Simulated, model: Model) -> Array:
    return np.array([[made.truth[name] for name in model.parameters.names]])


def values(**changes: float) -> Values:
    nominal = {"f": 0.008, "s_u": 7e-6, "s_v": 7.4e-6, "u_0": 320.0, "v_0": 240.0, "k": 900.0, "b": 0.14, "theta": 0.45}
    return {name: np.array([value]) for name, value in (nominal | changes).items()}


@pytest.mark.parametrize("c", [0.5, 1.3])
def test_scaling_f_with_pitch_and_k_changes_no_point(made, c):
    model = Model(made.dataset)
    x = truth_of(made, model)
    scaled = x.copy()
    scaled[:, model.parameters.columns(["f", "s_u", "s_v"])] *= c
    scaled[:, model.parameters.columns(["k"])] /= c**2
    np.testing.assert_allclose(model.residuals(scaled), model.residuals(x), rtol=0, atol=1e-12)
    held = model.fix_gauge(scaled[0])
    assert held[0] == pytest.approx(model.parameters.nominal[0])
    np.testing.assert_allclose(model.residuals(held[None]), model.residuals(x), rtol=0, atol=1e-12)


@pytest.mark.parametrize("axis", ["u", "v"])
def test_a_point_follows_the_contracts_formula(axis):
    v = values(k=0.0)
    u_m, v_m = (100.3 - 320) * 7e-6, (301.9 - 240) * 7.4e-6
    flat = undistort(metric(np.array([[[100.3, 301.9]]]), v), v["k"])
    point = intersect(rays(flat, v["f"], axis), laser_plane(v))[0, 0]
    x, y = (v_m, -u_m) if axis == "u" else (u_m, v_m)
    rho = 0.14 / (x + 0.008 * np.tan(0.45))
    np.testing.assert_allclose(point, rho * np.array([x, y, 0.008]), rtol=1e-12)


@pytest.mark.parametrize("b", [0.14, -0.14])
def test_points_lie_on_the_sheet_for_either_sign_of_baseline_and_tilt(b):
    v = values(b=b, theta=-0.3 if b < 0 else 0.3)
    pixel = RNG.uniform([0, 0], [640, 480], (1, 50, 2))
    point = intersect(rays(undistort(metric(pixel, v), v["k"]), v["f"], "u"), laser_plane(v))
    off = point[..., 0] * np.cos(v["theta"]) + point[..., 2] * np.sin(v["theta"]) - b * np.cos(v["theta"])
    assert np.abs(off).max() < 1e-12


@pytest.mark.parametrize("axis", ["u", "v"])
@pytest.mark.parametrize("k", [0.0, 900.0, -900.0])
def test_projection_undoes_triangulation(axis, k):
    v = values(k=k)
    pixel = RNG.uniform([250, 190], [390, 290], (1, 50, 2))
    point = intersect(rays(undistort(metric(pixel, v), v["k"]), v["f"], axis), laser_plane(v))
    seen = project(point, v, axis)
    ahead = point[0, :, 2] > 0
    assert ahead.any()
    np.testing.assert_allclose(seen[0, ahead], pixel[0, ahead], atol=1e-8)
    assert np.isnan(seen[0, ~ahead]).all()


def test_zyz_angles_are_the_papers_matrix():
    w, phi, psi = 0.3, -0.4, 0.7
    c, s = np.cos, np.sin
    paper = np.array(
        [
            [c(w) * c(phi) * c(psi) - s(w) * s(psi), -c(w) * c(phi) * s(psi) - s(w) * c(psi), c(w) * s(phi)],
            [s(w) * c(phi) * c(psi) + c(w) * s(psi), -s(w) * c(phi) * s(psi) + c(w) * c(psi), s(w) * s(phi)],
            [-s(phi) * c(psi), s(phi) * s(psi), c(phi)],
        ]
    )
    np.testing.assert_allclose(from_angles(*map(np.array, (w, phi, psi)), order="zyz"), paper, atol=1e-15)


def test_the_bracket_turns_before_the_small_angles(made):
    model = Model(made.dataset)
    v = model.parameters.values(truth_of(made, model))
    R = from_quaternion(np.array(made.dataset.bracket_quat)) @ from_angles(v["w"], v["phi"], v["psi"])
    t = np.stack([v["t_x"], v["t_y"], v["t_z"]], axis=-1)
    np.testing.assert_allclose(model.blocks.sensor.in_cell(v, model.perturb(v)).mount[:, 0], pose(R, t), atol=1e-15)


def test_measured_flange_poses_do_as_well_as_joint_angles(made):
    dataset = made.dataset
    bare = on_flange_poses(dataset)
    x = truth_of(made, Model(dataset))
    np.testing.assert_allclose(Model(bare).residuals(x), Model(dataset).residuals(x), atol=1e-14)


def test_an_unplaced_target_follows_in_closed_form(made):
    T_target_base = pose(from_angles(*(np.array(a) for a in (0.1, -0.2, 0.7))), np.array([0.3, -0.1, 0.2]))
    dataset = made.dataset
    own = replace(dataset, placed=False, points=replace(dataset.points, xyz=apply(T_target_base, dataset.points.xyz)))
    model = Model(own)
    scanner = {name: np.array([value]) for name, value in made.truth.items()}
    completed = model.completed(scanner)
    x = np.array([[completed[name][0] for name in model.parameters.names]])
    assert np.abs(model.residuals(x)).max() < 1e-9
    assert model.cost(x[:0]).shape == (0,)


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ((), r"my cell has no points\.csv yet\. Run `robolaser extract '.*my cell'` first"),
        (("points.csv",), r"^There are no points"),
        (None, r"^There are no points"),
    ],
)
def test_without_points_the_way_to_some_is_named_where_there_is_one(made, tmp_path, files, said):
    folder = tmp_path / "my cell"
    folder.mkdir()
    for file in files or ():
        (folder / file).touch()
    bare = replace(made.dataset, points=made.dataset.points.take(slice(0)), folder=None if files is None else folder)
    with pytest.raises(DataError, match=said):
        Model(bare)
