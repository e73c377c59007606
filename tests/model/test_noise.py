from dataclasses import replace

import cv2
import numpy as np
import pytest
from cells import Cell, at_truth, board_cell, on_board, stripe_cell, tracker_cell

from robolaser.data.board import Board
from robolaser.data.stated_noise import Noise
from robolaser.estimation.noise_estimate import known_sizes, noise_of
from robolaser.model.error_source import ErrorSource
from robolaser.model.forward_model import Model, jacobian_matrix
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.likelihood import NoiseLikelihood, PoseErrors, condensed, estimate, restricted
from robolaser.model.noise.repeats import pixel_repeats
from robolaser.model.noise.sources import error_sources
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.stripe import board_errors, pixel_moves
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


def states(cell: Cell, **noise: float) -> Cell:
    return Cell(replace(cell.dataset, noise=Noise(**noise)))


def dense(noise: NoiseModel) -> np.ndarray:
    return np.array(noise.seen_through(np.eye(3 * len(noise.sources[0].group))))


@pytest.fixture(scope="module")
def repeated() -> NoiseModel:
    """Noise at three nested levels: a row's, a point's, a pose's."""
    cell = stripe_cell(np.random.default_rng(3), poses=4, points=3, repeats=2, robot="scorbot_er7")
    model = cell.model()
    return NoiseModel(error_sources(model, cell.truth(model)), {"pixel": 0.2, "target": 5e-5, "joint": 3e-4})


def test_whitened_noise_is_independent_and_of_unit_variance(repeated):
    sigma = dense(repeated)
    W = repeated.whiten(np.eye(len(sigma))).T
    np.testing.assert_allclose(W @ sigma @ W.T, np.eye(len(sigma)), atol=1e-6)


def test_shuffled_rows_are_whitened_alike(repeated):
    turn = np.random.default_rng(0).permutation(24)
    e = np.random.default_rng(1).normal(size=(2, 24, 3))
    shuffled = NoiseModel(
        tuple(replace(s, effect=s.effect[turn], group=s.group[turn]) for s in repeated.sources), repeated.sigmas
    )
    whole = repeated.whiten(e).reshape(2, 24, 3)
    np.testing.assert_allclose(shuffled.whiten(e[:, turn]).reshape(2, 24, 3), whole[:, turn], rtol=1e-6, atol=1e-6)


def test_the_covariance_of_a_row_is_its_part_of_that_of_all(repeated):
    sigma = dense(repeated)
    np.testing.assert_allclose(repeated.covariances, [sigma[i : i + 3, i : i + 3] for i in range(0, 72, 3)], rtol=1e-9)


def test_poses_are_independent_and_rows_of_one_are_not(repeated):
    sigma = dense(repeated)
    assert np.all(sigma[:18, 18:] == 0.0)
    assert np.abs(sigma[:3, 3:6]).max() > 1e-3 * np.abs(sigma[:3, :3]).max()


def test_a_repeat_shares_its_points_error_but_not_its_pixels(repeated):
    def between(**only: float) -> np.ndarray:
        return dense(repeated.at({"pixel": 0.0, "target": 0.0, "joint": 0.0, **only}))[:3, 3:6]

    assert np.all(between(pixel=0.2) == 0.0)
    np.testing.assert_allclose(between(target=1e-3), 1e-6 * np.eye(3), atol=1e-15)


def test_joint_noise_moves_points_as_shifted_readings_do():
    cell = tracker_cell(np.random.default_rng(2), poses=6, robot="ur5")
    source = next(s for s in error_sources(cell.model(), cell.truth(cell.model())) if s.name == "joint")
    shift = 1e-6 * np.random.default_rng(4).normal(size=(6, 6))
    poses = replace(cell.dataset.poses, q=cell.dataset.poses.q + shift)
    moved = Cell(replace(cell.dataset, poses=poses)).missed() - cell.missed()
    expected = np.einsum("mkq,mq->mk", source.effect, shift[cell.dataset.points.pose])
    np.testing.assert_allclose(moved, expected, atol=1e-11)


class TestOnABoard:
    cell = board_cell(np.random.default_rng(6), poses=5, points=4)

    def effect(self, cell: Cell) -> np.ndarray:
        model = cell.model()
        values = model.parameters.values(cell.truth(model)[None])
        perturb = model.perturb(values)
        return pixel_moves(model.dataset, values, model.flange(values, perturb), perturb)

    def test_pixel_noise_moves_a_residual_along_its_viewing_ray_only(self):
        model = self.cell.model()
        values = at_truth(model.parameters.names)
        perturb = model.perturb(values)
        T_base_flange = model.flange(values, perturb)
        T_flange_camera = model.blocks.sensor.in_cell(values, perturb).mount
        centre = (T_base_flange @ T_flange_camera)[0, self.cell.dataset.points.pose, :3, 3]
        ray = scanner_geometry.in_base(model.blocks.sensor.dataset, values, T_base_flange, perturb)[0] - centre
        ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
        effect = self.effect(self.cell)
        across = effect - ray[..., None] * np.einsum("mk,mkq->mq", ray, effect)[:, None]
        assert np.abs(across).max() < 1e-9 * np.abs(effect).max()

    def test_target_and_prediction_move_with_one_pixel(self):
        step = 1e-3
        effect = self.effect(self.cell)
        for axis in (0, 1):
            pixel = self.cell.dataset.points.pixel + step * np.eye(2)[axis]
            points = replace(self.cell.dataset.points, pixel=pixel, xyz=on_board(self.cell, pixel))
            moved = Cell(replace(self.cell.dataset, points=points)).missed() - self.cell.missed()
            np.testing.assert_allclose(moved / step, effect[..., axis], atol=2e-3 * np.abs(effect).max())

    def test_a_placed_board_is_the_plane_through_its_points(self):
        model = self.cell.model()
        values = at_truth(model.parameters.names)
        known = model.blocks.known(values, model.flange(values), model.perturb(values))[0]
        parameters = {k: v for k, v in self.cell.dataset.parameters.items() if not k.startswith("target.")}
        placed = replace(
            self.cell.dataset, placed=True, parameters=parameters, points=replace(self.cell.dataset.points, xyz=known)
        )
        np.testing.assert_allclose(self.effect(Cell(placed)), self.effect(self.cell), rtol=1e-6, atol=1e-12)

    def test_corners_that_err_shift_the_rows_of_their_image_together(self):
        board, rng, size, trials = Board(7, 5, 0.01), np.random.default_rng(3), 2e-5, 3000
        at = np.array([[0.005, 0.01], [0.02, 0.015], [0.04, 0.018], [0.055, 0.03]])
        xyz = np.pad(at, ((0, 0), (0, 1)))
        points = replace(self.cell.dataset.points.take(np.arange(4)), pose=np.zeros(4, int), xyz=xyz)
        source = board_errors(board, points, np.eye(4), np.ones(4))
        grid = board.square_m * np.stack(np.meshgrid(range(board.columns), range(board.rows)), axis=-1).reshape(-1, 2)
        shifts = np.empty((trials, *at.shape))
        for i in range(trials):
            H, _ = cv2.findHomography(grid, grid + rng.normal(0.0, size, grid.shape))
            shifts[i] = cv2.perspectiveTransform(at[None], H)[0] - at
        assert np.all(source.effect[:, 2] == 0.0)
        effect = source.effect[:, :2].reshape(-1, 8)
        expected, found = size**2 * effect @ effect.T, np.cov(shifts.reshape(trials, -1).T)
        np.testing.assert_allclose(found, expected, atol=0.1 * expected.max())
        assert np.all(source.group == 0)


def test_pixel_noise_is_read_from_repeats_whatever_the_targets_do():
    cell = stripe_cell(np.random.default_rng(1), poses=10, points=8, repeats=3, robot="scorbot_er7")
    found = pixel_repeats(cell.shaken(np.random.default_rng(2), pixel=0.15, target=1e-3, joint=1e-3).dataset)
    assert found.sigma_px == pytest.approx(0.15, rel=4 / np.sqrt(2 * 2 * 160))


def test_gross_errors_do_not_pass_for_pixel_noise():
    cell = stripe_cell(np.random.default_rng(1), poses=10, points=8, repeats=3, robot="scorbot_er7")
    shaken = cell.shaken(np.random.default_rng(2), pixel=0.15)
    pixel = shaken.dataset.points.pixel.copy()
    pixel[::25] += 20.0
    points = replace(shaken.dataset.points, pixel=pixel)
    assert pixel_repeats(replace(shaken.dataset, points=points)).sigma_px == pytest.approx(0.15, rel=0.2)


def test_whole_pixels_of_which_most_repeat_alike_are_not_without_noise():
    cell = stripe_cell(np.random.default_rng(1), poses=10, points=8, repeats=3, robot="scorbot_er7")
    shaken = cell.shaken(np.random.default_rng(2), pixel=0.15)
    points = replace(shaken.dataset.points, pixel=np.round(shaken.dataset.points.pixel))
    assert 0.15 < pixel_repeats(replace(shaken.dataset, points=points)).sigma_px < 0.45


def test_too_few_repeats_say_nothing_nor_does_a_column_that_never_changes():
    cell = stripe_cell(np.random.default_rng(1), poses=2, points=4, repeats=2, robot="scorbot_er7")
    assert pixel_repeats(cell.dataset) is None
    cell = stripe_cell(np.random.default_rng(1), poses=20, points=8, repeats=3)
    shaken = cell.shaken(np.random.default_rng(2), pixel=0.15)
    pixel = np.insert(shaken.dataset.points.pixel[:, 1:], 0, 63.1, axis=1)
    assert pixel_repeats(replace(shaken.dataset, points=replace(shaken.dataset.points, pixel=pixel))) is None


def sizes_of(cell: Cell, rng: np.random.Generator, count: int, **noise: float) -> dict[str, np.ndarray]:
    """What is found on many measurements of a cell, each fitted by its Jacobian."""
    model = cell.model()
    truth = cell.truth(model)
    J, sources = jacobian_matrix(model, truth), error_sources(model, truth)
    scaled = J * model.parameters.width
    found = []
    for _ in range(count):
        shaken = cell.shaken(rng, **noise)
        e = shaken.missed().reshape(-1)
        e = e - scaled @ (np.linalg.pinv(scaled, rcond=1e-9) @ e)
        likelihood = NoiseLikelihood(sources, shaken.dataset.points.pose, e.reshape(-1, 3), J)
        found.append(likelihood.likeliest(known_sizes(sources, shaken.dataset))[0].sigmas)
    return {name: np.array([each[name] for each in found]) for name in found[0]}


@pytest.mark.parametrize(
    ("noise", "other"),
    [({"point": 3e-5, "joint": 2e-4}, ("probe",)), ({"point": 1e-4, "joint": 0.0}, ("joint", "probe"))],
)
def test_injected_tracker_noise_is_found_again(noise, other):
    cell = tracker_cell(np.random.default_rng(7), poses=40, robot="scorbot_er7")
    found = sizes_of(cell, np.random.default_rng(8), 12, **noise)
    for name, size in noise.items():
        if size > 0:
            assert float(np.sqrt(np.mean(found[name] ** 2))) == pytest.approx(size, rel=0.1), name
    for name in other:
        scale = 0.5 if name == "joint" else 1.0  # an arm's length
        assert np.sqrt(np.mean(found[name] ** 2)) * scale < 0.5 * max(noise["point"], 0.6 * noise["joint"])


def test_injected_stripe_noise_is_found_again_beside_stated_pixels():
    cell = states(stripe_cell(np.random.default_rng(9), poses=30, points=8, robot="scorbot_er7"), pixel_px=0.1)
    found = sizes_of(cell, np.random.default_rng(10), 8, pixel=0.1, target=1e-4, joint=2e-4)
    assert set(found["pixel"]) == {0.1}
    assert np.sqrt(np.mean(found["target"] ** 2)) == pytest.approx(1e-4, rel=0.1)
    assert np.sqrt(np.mean(found["joint"] ** 2)) == pytest.approx(2e-4, rel=0.1)


def test_noise_beyond_what_is_stated_is_found_at_the_level_of_the_pose():
    cell = states(tracker_cell(np.random.default_rng(11), poses=40, robot="scorbot_er7"), point_m=1e-5)
    model = states(cell.shaken(np.random.default_rng(12), point=1e-5, joint=1e-3), point_m=1e-5).model()
    noise = noise_of(model, cell.truth(model))
    assert noise.sigmas["point"] == 1e-5
    assert "point" not in noise.estimated
    assert noise.sigmas["joint"] == pytest.approx(1e-3, rel=0.3)


def test_fitted_numbers_do_not_make_the_noise_seem_small():
    cell = tracker_cell(np.random.default_rng(13), poses=5, robot="scorbot_er7")  # 45 residuals, 15 parameters
    cell = states(cell, joint_rad=0.0)
    found = sizes_of(cell, np.random.default_rng(14), 40, point=1e-4)
    assert np.mean(found["point"] ** 2 + found["probe"] ** 2) == pytest.approx(1e-8, rel=0.2)


def test_likelihood_slopes_are_those_of_finite_differences(repeated):
    rng = np.random.default_rng(15)
    unit = [np.einsum("nij,nkj->nik", A, A) for A in rng.normal(size=(2, 4, 6, 3))]
    known, e, Q = np.tile(np.eye(6), (4, 1, 1)), rng.normal(size=(4, 6)), rng.normal(size=(4, 6, 5))
    at, step = np.array([0.3, -0.4]), 1e-5
    _, expected, there, _ = restricted(at, known, unit, e, Q)
    up, down = ([restricted(at + way * step * axis, known, unit, e, Q)[0] for axis in np.eye(2)] for way in (1, -1))
    np.testing.assert_allclose(expected - there, (np.array(up) - np.array(down)) / (2 * step), rtol=1e-6)


def test_sources_that_are_all_on_their_bounds_stay_there():
    rng = np.random.default_rng(18)
    unit = [np.einsum("nij,nkj->nik", A, A) for A in rng.normal(size=(2, 4, 6, 3))]
    known, e, Q = np.tile(np.eye(6), (4, 1, 1)), 1e-9 * rng.normal(size=(4, 6)), rng.normal(size=(4, 6, 5))
    least = np.array([1e-3, 2e-3])
    np.testing.assert_allclose(estimate(known, unit, e, Q, least)[0], least)


def test_sources_that_the_residuals_would_make_larger_stay_at_their_upper_bounds():
    rng = np.random.default_rng(18)
    unit = [np.einsum("nij,nkj->nik", A, A) for A in rng.normal(size=(2, 4, 6, 3))]
    known, e, Q = np.tile(1e-6 * np.eye(6), (4, 1, 1)), rng.normal(size=(4, 6)), rng.normal(size=(4, 6, 2))
    most = np.array([1e-2, 2e-2])
    for larger in (1.0, 1e6):
        np.testing.assert_allclose(estimate(known, unit, larger * e, Q, np.zeros(2), most)[0], most)


def test_one_sources_optimum_is_that_of_the_likelihood_of_whole_poses():
    rng = np.random.default_rng(21)
    A, C = rng.normal(size=(12, 6, 2)), rng.normal(size=(12, 6, 9))
    unit, known = A @ A.swapaxes(1, 2), C @ C.swapaxes(1, 2)
    e = (C @ rng.normal(size=(12, 9, 1)) + 0.7 * A @ rng.normal(size=(12, 2, 1)))[..., 0]
    Q = rng.normal(size=(12, 6, 5))
    (found,), value = estimate(known, [unit], e, Q, np.zeros(1))
    there, expected, moved, _ = restricted(np.log([found]), known, [unit], e, Q)
    assert value == pytest.approx(there, rel=1e-9)
    assert expected == pytest.approx(moved, rel=1e-3)


@pytest.mark.parametrize("shortest", [12, 1])
def test_condensed_poses_have_the_likelihood_of_whole_ones(shortest):
    rng = np.random.default_rng(22)
    is_row = np.arange(12) < np.array([12, shortest, 9, 12, 12, 12, 10, 12])[:, None]
    A, Q, e = (np.where(is_row[..., None], rng.normal(size=(8, 12, k)), 0.0) for k in (2, 5, 1))
    alike, floor = is_row[..., None] * np.eye(12), np.where(is_row, 0.1, 1.0)[..., None] * np.eye(12)
    whole = PoseErrors({"own": alike, "pose": A @ A.swapaxes(1, 2)}, floor, e[..., 0], Q, np.ones(8))
    few = condensed(whole, is_row)
    assert few.e.shape[1] == 2
    at = np.array([0.3, -0.4])
    answers = (restricted(at, one.floor, list(one.unit.values()), one.e, one.Q, one.times) for one in (whole, few))
    for of_whole, of_few in zip(*answers, strict=True):
        np.testing.assert_allclose(of_few, of_whole, rtol=1e-10)


@pytest.mark.parametrize("grown", [1.0, 1.5, 6.0])
def test_the_score_test_promises_at_least_half_of_what_stated_noise_gains_by_growing(grown):
    cell = stripe_cell(np.random.default_rng(9), poses=30, points=8, robot="scorbot_er7")
    shaken = cell.shaken(np.random.default_rng(10), pixel=0.1 * grown, target=3e-5, joint=2e-4)
    model, x = shaken.model(), cell.truth(cell.model())
    left = model.residuals(x[None])[0]
    likelihood = NoiseLikelihood(error_sources(model, x), shaken.dataset.points.pose, left, jacobian_matrix(model, x))
    stated = {"target": (3e-5, "stated")}
    noise, cost = likelihood.likeliest({**stated, "pixel": (0.1, "stated")})
    promised = likelihood.gain_of_growth(noise, ["pixel"])
    assert promised > 0.5 * (cost - likelihood.likeliest(stated, {"pixel": 0.1})[1]) - 1e-3
    assert (promised > 4.0) == (grown > 1.0)


@pytest.mark.parametrize("size", [0.0, 2e-4])
def test_the_score_test_of_a_source_without_size_tells_whether_it_explains_anything(size):
    cell = stripe_cell(np.random.default_rng(9), poses=30, points=8, robot="scorbot_er7")
    shaken = cell.shaken(np.random.default_rng(10), pixel=0.1, joint=size)
    model, x = shaken.model(), cell.truth(cell.model())
    left = model.residuals(x[None])[0]
    likelihood = NoiseLikelihood(error_sources(model, x), shaken.dataset.points.pose, left, jacobian_matrix(model, x))
    known = {"target": (0.0, "stated"), "pixel": (0.1, "stated")}
    without, _ = likelihood.likeliest({**known, "joint": (0.0, "stated")})
    assert (likelihood.gain_of_growth(without, ["joint"]) > 4.0) == (size > 0.0)


def test_what_a_bound_keeps_from_the_fit_counts_as_noise_left_over():
    cell = tracker_cell(np.random.default_rng(16), poses=20, robot="scorbot_er7").shaken(
        np.random.default_rng(17), point=1e-4
    )
    column = cell.model().parameters.names.index("base.x")
    item = cell.dataset.parameters["base.x"]
    at = replace(item, lower=item.nominal + 0.01, nominal=item.nominal + 0.01)  # 10 mm beside the truth
    bounded = Cell(replace(cell.dataset, parameters={**cell.dataset.parameters, "base.x": at}))
    x = cell.truth(cell.model())
    free = noise_of(cell.model(), x)
    x[column] = at.lower
    kept = noise_of(bounded.model(), x)
    rms = [np.sqrt(np.trace(noise.covariances.mean(axis=0))) for noise in (free, kept)]
    assert rms[0] < 1e-3
    assert rms[1] > 5e-3


def test_a_printed_target_is_never_taken_for_perfect():
    cell = board_cell(np.random.default_rng(18), poses=12, points=8).shaken(np.random.default_rng(19), pixel=0.2)
    model = cell.model()
    assert noise_of(model, cell.truth(model)).sigmas["target"] == pytest.approx(1e-5)


def test_a_turn_about_the_only_ball_of_a_pose_is_no_source_of_noise():
    dataset = simulate(find_robot("scorbot_er7"), kind="profile", poses=12, noise=Noise(joint_rad=1e-5), seed=3).dataset
    model = Model(dataset)
    assert "flange_turn" not in noise_of(model, model.parameters.nominal).sigmas


def test_a_source_that_moves_no_row_is_at_its_least_and_the_others_are_as_without_it():
    cell = stripe_cell(np.random.default_rng(9), poses=30, points=8, robot="scorbot_er7")
    shaken = cell.shaken(np.random.default_rng(10), pixel=0.1, target=3e-5, joint=2e-4)
    model, x = shaken.model(), cell.truth(cell.model())
    sources, J = error_sources(model, x), jacobian_matrix(model, x)
    turn = ErrorSource("flange_turn", np.zeros((len(shaken.dataset.points), 3, 3)), shaken.dataset.points.pose, "rad")
    found, without = (
        NoiseLikelihood(chosen, shaken.dataset.points.pose, model.residuals(x[None])[0], J).likeliest({})[0]
        for chosen in ((*sources, turn), sources)
    )
    assert found.sigmas == {**without.sigmas, "flange_turn": turn.least}
