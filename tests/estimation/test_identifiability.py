from dataclasses import replace

import numpy as np
import pytest
from cells import TRUTH, Cell, board_cell, given, stripe_cell, tracker_cell
from functions import FunctionProblem

from robolaser.data.stated_noise import Noise
from robolaser.estimation.fisher_information import Information
from robolaser.estimation.identifiability import null_directions, standard_errors, unidentifiable
from robolaser.estimation.noise_estimate import known_sizes, noise_of
from robolaser.estimation.solver import solve
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.joint_offset import JointOffset
from robolaser.model.forward_model import Model, jacobian_matrix
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.likelihood import NoiseLikelihood
from robolaser.model.noise.sources import error_sources
from robolaser.model.sensors.stripe import SCANNER

TRIALS = 50
ROUNDED = Information(np.eye(2), np.eye(2), np.diag([4.0, -1e-30]), np.ones(2))
"""Of which one variance is negative by rounding, as where all poses are the same."""


def likeliest(dataset, sources, residuals, J):
    return NoiseLikelihood(sources, dataset.points.pose, residuals, J).likeliest(known_sizes(sources, dataset))[0]


def said(J, noise, **more):
    """What rows of three numbers say by their derivatives (3m, d)."""
    return Information.of(J.T.reshape(J.shape[1], -1, 3), noise, **more)


@pytest.mark.parametrize("bounded", [[0.0, 0.0], [1.0, 0.0]])
def test_rounding_makes_no_standard_error_imaginary(bounded):
    std = standard_errors(ROUNDED, fixed=np.zeros(2, dtype=bool), bounded=np.array(bounded))
    np.testing.assert_array_equal(std, [np.nan if bounded[0] else 2.0, 0.0])


def coverage(cell: Cell, rng: np.random.Generator, *, stated: Noise, **noise: float) -> tuple[float, float]:
    """How often ±1.96 standard errors hold the truth, over trials and parameters, by the plain and the weighted fit.

    The errors are real, the fit is linear.
    """
    model = cell.model()
    truth = cell.truth(model)
    J, sources = jacobian_matrix(model, truth), error_sources(model, truth)
    held = np.isin(model.parameters.names, ["f"])
    scale = model.parameters.width[~held]
    free = J[:, ~held]
    plain = scale[:, None] * np.linalg.pinv(free * scale)
    hits = []
    for _ in range(TRIALS):
        shaken = cell.shaken(rng, **noise)
        e = shaken.missed().reshape(-1)
        step = -plain @ e
        found = likeliest(replace(shaken.dataset, noise=stated), sources, (e + free @ step).reshape(-1, 3), J)
        weighted = -scale * np.linalg.lstsq(found.whiten(free.T).T * scale, found.whiten(e[None])[0])[0]
        both = (standard_errors(said(J, found, weights=way), fixed=held)[~held] for way in (None, found))
        hits.append([np.abs(x) < 1.96 * std for x, std in zip((step, weighted), both, strict=True)])
    plain_share, weighted_share = np.mean(hits, axis=(0, 2))
    return float(plain_share), float(weighted_share)


CASES = {
    "target points of 0.3 mm, 25 of them": (
        lambda rng: stripe_cell(rng, poses=5, points=5, robot="scorbot_er7"),
        Noise(),
        {"target": 3e-4},
    ),
    "pixels, seen twice": (
        lambda rng: stripe_cell(rng, poses=8, points=6, repeats=2, robot="scorbot_er7"),
        Noise(),
        {"pixel": 0.2, "target": 3e-5},
    ),
    "joint readings": (
        lambda rng: tracker_cell(rng, poses=24, robot="scorbot_er7"),
        Noise(point_m=2e-5),
        {"point": 2e-5, "joint": 2e-4},
    ),
    "one pixel for target and prediction": (
        lambda rng: board_cell(rng, poses=12, points=8),
        Noise(),
        {"pixel": 0.2, "target": 2e-5, "flange": 1e-4},
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_two_standard_errors_hold_the_truth_nineteen_times_in_twenty(case):
    rng = np.random.default_rng(20)
    cell, stated, noise = CASES[case]
    plain, weighted = coverage(cell(rng), rng, stated=stated, **noise)
    assert 0.90 <= plain <= 0.98
    assert 0.90 <= weighted <= 0.98


def test_a_true_fit_to_real_errors_is_held_too():
    cell = tracker_cell(np.random.default_rng(21), poses=12, robot="scorbot_er7")
    model = cell.model()
    truth, rng = cell.truth(model), np.random.default_rng(22)
    sources, hits = error_sources(model, truth), []
    for _ in range(TRIALS):
        shaken = cell.shaken(rng, point=3e-4).model().dataset.points.xyz - cell.dataset.points.xyz

        def residuals(x, shaken=shaken):
            return (model.residuals(x) + shaken).reshape(len(x), -1)

        problem = FunctionProblem(residuals, truth, model.parameters.lower, model.parameters.upper, axes=3)
        x = solve(problem, truth[None], tol=1e-9).x[0]
        J = jacobian_matrix(model, x)
        noise = likeliest(model.dataset, sources, residuals(x[None]).reshape(-1, 3), J)
        std = standard_errors(said(J, noise), fixed=np.zeros(len(truth), dtype=bool))
        hits.append(np.abs(x - truth) < 1.96 * std)
    assert 0.90 <= np.mean(hits) <= 0.98


def known_noise(model: Model, x: np.ndarray, **sigmas: float) -> NoiseModel:
    sources = error_sources(model, x)
    return NoiseModel(sources, {source.name: sigmas.get(source.name, 0.0) for source in sources})


@pytest.fixture(scope="module")
def tracked():
    model = tracker_cell(np.random.default_rng(23), poses=10, robot="scorbot_er7").model()
    x = np.array([TRUTH[name] for name in model.parameters.names])
    return model, x, jacobian_matrix(model, x)


def test_weighing_by_the_noise_loses_no_parameter_any_sureness(tracked):
    model, x, J = tracked
    noise = known_noise(model, x, point=2e-5, joint=3e-4)
    plain, best = (said(J, noise, weights=weights).covariance(np.arange(len(x))) for weights in (None, noise))
    assert np.linalg.eigvalsh((plain - best) / model.parameters.width / model.parameters.width[:, None]).min() > -1e-9
    assert np.trace(best) < 0.9 * np.trace(plain)


def test_with_rows_alike_both_estimates_are_one(tracked):
    model, x, J = tracked
    noise = known_noise(model, x, point=2e-5)
    plain, best = (said(J, noise, weights=weights).covariance(np.arange(len(x))) for weights in (None, noise))
    np.testing.assert_allclose(plain, best, rtol=1e-6, atol=1e-12 * np.abs(best).max())


def test_errors_shared_by_a_pose_count_for_more_than_errors_of_rows(tracked):
    model, x, J = tracked
    base = [name.startswith("base.x") for name in model.parameters.names]
    alone, shared = (
        said(J, known_noise(model, x, **{name: 1e-4})).covariance(np.arange(len(x)))[base][:, base][0, 0]
        for name in ("point", "probe")
    )
    assert shared > 2.0 * alone


def test_units_of_the_parameters_do_not_matter(tracked):
    model, x, J = tracked
    noise = known_noise(model, x, point=2e-5, joint=1e-4)
    factor = 10.0 ** np.random.default_rng(24).uniform(-6, 6, J.shape[1])
    std = standard_errors(said(J, noise), fixed=np.zeros(len(x), dtype=bool))
    scaled = standard_errors(said(J / factor, noise), fixed=np.zeros(len(x), dtype=bool))
    np.testing.assert_allclose(scaled, std * factor, rtol=1e-6)


def found_in(cell: Cell, *candidate_effects: CandidateEffect) -> list[tuple[str, ...]]:
    model = Model(cell.dataset, candidate_effects)
    x = cell.truth(model)
    noise = known_noise(model, x, pixel=0.1, target=3e-5, point=3e-5)
    return [
        each.parameters
        for each in unidentifiable(
            said(jacobian_matrix(model, x), noise), model.parameters.names, model.parameters.width
        )
    ]


GAUGE = ("f", "s_u", "s_v", "k")


def test_a_well_posed_cell_has_the_gauge_of_the_focal_length_and_no_more():
    assert found_in(stripe_cell(np.random.default_rng(25), poses=40, points=10, robot="ur5")) == [GAUGE]


def test_a_tracker_has_no_gauge(tracked):
    _, x, J = tracked
    assert null_directions(J).shape == (0, len(x))


def test_the_gauge_is_read_from_the_derivatives_not_known_beforehand():
    cell = stripe_cell(np.random.default_rng(25), poses=40, points=10, robot="ur5")
    model = cell.model()
    x = cell.truth(model)
    (direction,) = null_directions(jacobian_matrix(model, x))
    scaled = direction / direction[0] * x[0]
    expected = {"f": TRUTH["f"], "s_u": TRUTH["s_u"], "s_v": TRUTH["s_v"], "k": -2 * TRUTH["k"]}
    np.testing.assert_allclose(scaled, [expected.get(name, 0.0) for name in model.parameters.names], rtol=1e-4)


def test_a_sheet_seen_without_distortion_has_two_freedoms_more():
    # a pinhole's view of a sheet without roll is a projective map of 10 numbers, which all 13 but k shape
    cell = stripe_cell(np.random.default_rng(25), poses=40, points=10, robot="ur5")
    model = cell.model()
    x = cell.truth(model)
    x[model.parameters.columns(["k"])] = 0.0
    directions = null_directions(jacobian_matrix(model, x))
    names = np.array(model.parameters.names)
    assert len(directions) == 3
    assert ("f", "s_u", "s_v") in [tuple(names[direction != 0]) for direction in directions]
    assert "k" not in names[(directions != 0).any(axis=0)]


def test_an_offset_of_the_last_joint_is_named_with_the_hand_eye_that_takes_it():
    cell = stripe_cell(np.random.default_rng(26), poses=40, points=10, robot="scorbot_er7")
    found = found_in(cell, CandidateEffect(JointOffset, "joint_5"))
    assert GAUGE in found
    (offset,) = (names for names in found if "joint_offset.joint_5.offset" in names)
    assert {"psi", "t_x", "t_y"} <= set(offset) <= {"w", "phi", "psi", "t_x", "t_y", "joint_offset.joint_5.offset"}


def test_an_offset_of_a_middle_joint_is_not():
    cell = stripe_cell(np.random.default_rng(26), poses=40, points=10, robot="scorbot_er7")
    assert found_in(cell, CandidateEffect(JointOffset, "joint_3")) == [GAUGE]


@pytest.mark.parametrize("phi", [0.0, 1e-4])
def test_zyz_angles_near_their_pole_are_named(phi):
    cell = stripe_cell(np.random.default_rng(27), poses=40, points=10, robot="ur5", angles="zyz")
    cell = Cell(replace(cell.dataset, parameters=given(SCANNER, phi=phi)))
    model = cell.model()
    x = model.parameters.nominal
    noise = known_noise(model, x, pixel=0.1, target=3e-5)
    known = said(jacobian_matrix(model, x), noise)
    found = unidentifiable(known, model.parameters.names, model.parameters.width)
    assert ("w", "psi") in [each.parameters for each in found]
    std = standard_errors(known, fixed=np.isin(model.parameters.names, ["f"]))
    angles = std[model.parameters.columns(["w", "psi"])]
    assert np.all(np.isnan(angles) | (angles > 0.1))


def test_no_parameter_of_a_null_direction_has_a_standard_error(tracked):
    model, x, J = tracked
    twin = np.column_stack([J, J[:, 0] + 2.0 * J[:, 1], np.zeros(len(J))])
    noise = known_noise(model, x, point=2e-5)
    std = standard_errors(said(twin, noise), fixed=np.zeros(twin.shape[1], dtype=bool))
    alone = standard_errors(said(J, noise), fixed=np.zeros(len(x), dtype=bool))
    assert np.isnan(std[[0, 1, -2, -1]]).all()
    np.testing.assert_allclose(std[2:-2], alone[2:], rtol=1e-6)


def test_null_directions_that_share_no_parameter_come_out_apart(tracked):
    _, x, J = tracked
    turned = np.column_stack([J, J[:, 0] - J[:, 4], J[:, 1] + 3.0 * J[:, 2]])
    parts = {tuple(np.flatnonzero(direction)) for direction in null_directions(turned)}
    assert parts == {(0, 4, len(x)), (1, 2, len(x) + 1)}


def test_held_parameters_are_known_and_those_on_a_bound_are_as_uncertain_as_data_or_bounds_leave_them(tracked):
    model, x, J = tracked
    noise = known_noise(model, x, point=2e-5)
    none, one = np.zeros(len(x), dtype=bool), np.arange(len(x)) == 3
    known = said(J, noise)
    free = standard_errors(known, fixed=none)
    held = standard_errors(known, fixed=one)
    widths = 1e-12, 1e-6, 1.0
    narrow, some, wide = (standard_errors(known, fixed=none, bounded=np.where(one, width, 0.0)) for width in widths)
    assert np.isnan(held[3])
    assert np.isnan(narrow[3])
    assert np.all(held[~one] <= free[~one] * (1 + 1e-9))
    assert (held[~one] < 0.99 * free[~one]).any()
    np.testing.assert_allclose(narrow[~one], held[~one], rtol=1e-6)
    assert np.all(some[~one] >= held[~one])
    answer = np.linalg.lstsq(J[:, ~one], J[:, 3])[0]
    np.testing.assert_allclose(some[~one] ** 2 - held[~one] ** 2, 1e-12 * answer**2 / 12, rtol=1e-3, atol=1e-18)
    np.testing.assert_allclose(wide[~one] ** 2 - held[~one] ** 2, (free[3] * answer) ** 2, rtol=1e-3, atol=1e-18)
    np.testing.assert_allclose(wide[~one], free[~one], rtol=1e-6)


def test_what_twenty_five_points_barely_see_is_named_with_its_size():
    cell = stripe_cell(np.random.default_rng(28), poses=5, points=5, robot="scorbot_er7")
    model = cell.model()
    x = cell.truth(model)
    noise = known_noise(model, x, target=1e-3)
    known = said(jacobian_matrix(model, x), noise)
    found = unidentifiable(known, model.parameters.names, model.parameters.width)
    weak = [each for each in found if each.parameters != GAUGE]
    assert weak
    assert all(
        "times the distance between the bounds" in each.reason and each.parameters[0] in each.reason for each in weak
    )
    assert "b" in {name for each in weak for name in each.parameters}


def test_noise_of_a_fitted_model_needs_no_more_than_the_model():
    cell = tracker_cell(np.random.default_rng(29), poses=10, robot="scorbot_er7").shaken(
        np.random.default_rng(30), point=1e-4
    )
    model = cell.model()
    x = cell.truth(model)
    J, e = jacobian_matrix(model, x), model.residuals(x[None])[0]
    assert noise_of(model, x).sigmas == likeliest(model.dataset, error_sources(model, x), e, J).sigmas


def test_what_parts_say_adds_up_to_what_all_rows_say(tracked):
    model, x, J = tracked
    noise = known_noise(model, x, point=2e-5, joint=3e-4)
    half = model.dataset.points.pose < 5
    for weights in (None, noise):
        whole = said(J, noise, weights=weights)
        parts = [
            said(
                J[np.repeat(rows, 3)],
                noise.of_rows(np.flatnonzero(rows)),
                weights=None if weights is None else noise.of_rows(np.flatnonzero(rows)),
            )
            for rows in (half, ~half)
        ]
        every = np.arange(len(x))
        np.testing.assert_allclose((parts[0] + parts[1]).covariance(every), whole.covariance(every), rtol=1e-6)
