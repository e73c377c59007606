"""What decides, on numbers made by hand: each threshold is held by a test."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from robolaser.diagnosis import thresholds
from robolaser.diagnosis.fit import spread_of
from robolaser.diagnosis.held_out_gap import interval
from robolaser.diagnosis.localization import chance_ratio, likelihood_ratio, p_value
from robolaser.diagnosis.penalties import complexity_penalty, credibility, posterior_weights
from robolaser.diagnosis.result import Gap, RotationGap
from robolaser.diagnosis.verdict import Evidence, judge
from robolaser.estimation.certainty import CERTAIN
from robolaser.estimation.outliers import OUTLIER_SIGMA

GAP = Gap(nominal_m=None, calibrated_m=1e-4, after_m=1e-4, noise_floor_m=1e-4, after_ci95_m=(0.9e-4, 1.1e-4))
CLEAN = Evidence(GAP, expected_m=1e-4, explained=0.0, has_effects=False, localized=0.0, estimated_m=0.0)
EXPLAINED = replace(CLEAN, explained=8000.0, has_effects=True)


def with_gap(of: Evidence, after_m: float, least_m: float = 0.9e-4, before_m: float = 1e-4, **others) -> Evidence:
    gap = replace(GAP, after_m=after_m, after_ci95_m=(least_m, 1.0), calibrated_m=before_m)
    return replace(of, gap=gap, **others)


def turned(after: float, least: float) -> Evidence:
    """Rotations in units of their noise."""
    return replace(CLEAN, gap=replace(GAP, rotations=RotationGap(1e-3, after * 1e-3, least * 1e-3, 1e-3)))


SIX = np.eye(1, 20)[0] * 6.0
"""Residuals, one of which is six standard deviations."""


@pytest.mark.parametrize("of", ["positions", "rotations"])
def test_a_gap_that_chance_makes_in_one_of_forty_sound_data_sets_needs_a_location(of):
    def gap(high, least):
        if of == "positions":
            return with_gap(CLEAN, high * 1e-4, least * 1e-4)
        return turned(high, least)

    assert judge(gap(1.19, 1.04)) == "no_gap"
    assert judge(replace(gap(1.19, 1.04), localized=20.0)) == "unexplained"
    assert judge(gap(1.3, 1.15)) == "unexplained"


def test_noise_of_centimetres_that_nobody_stated_is_a_wrong_description_of_the_cell():
    assert judge(CLEAN) == judge(replace(CLEAN, estimated_m=0.009)) == "no_gap"
    assert judge(replace(CLEAN, estimated_m=0.011)) == judge(replace(EXPLAINED, estimated_m=0.011)) == "unexplained"


def test_a_scatter_of_poses_twice_as_large_as_the_error_on_new_ones_is_no_noise():
    """A lens with two states looks like scatter along the line of sight, which is then granted in all directions."""
    assert judge(replace(CLEAN, scatter_m=1.9e-4)) == "no_gap"
    assert judge(replace(CLEAN, scatter_m=2.1e-4)) == judge(replace(EXPLAINED, scatter_m=2.1e-4)) == "unexplained"


@pytest.mark.parametrize("numbers", [2, 3])
def test_rows_of_normal_noise_are_as_large_as_their_median_lets_expect_and_a_few_large_ones_are_no_noise(numbers):
    white = np.random.default_rng(0).standard_normal((20_000, numbers))
    each = np.full(len(white), numbers)

    def spread(rows):
        return spread_of(np.square(rows).sum(axis=1), each)

    assert spread(white) == pytest.approx(1.0, abs=0.02)
    every_third = np.where(np.arange(len(white)) % 3 == 0, 20.0, 1.0)[:, None]
    assert spread(white * every_third) > thresholds.NO_NOISE
    assert spread(1e-7 * white**9) < thresholds.NO_NOISE  # rounding
    assert judge(replace(CLEAN, over_stated=2.7)) == "no_gap"
    assert judge(replace(CLEAN, over_stated=3.1)) == "unexplained"
    assert judge(replace(CLEAN, spread=1.9)) == "no_gap"
    assert judge(replace(CLEAN, spread=2.1)) == judge(replace(EXPLAINED, spread=2.1)) == "unexplained"


def test_an_effect_of_one_parameter_must_explain_twenty_and_a_half():
    assert complexity_penalty(1, 1) == thresholds.CHI2_PER_EFFECT + thresholds.CHI2_PER_PARAMETER == 20.5


def test_of_a_hundred_candidates_chance_reaches_the_fixed_part_once_in_158_data_sets():
    assert 1 / (100 * chi2.sf(thresholds.CHI2_PER_EFFECT, 1)) == pytest.approx(158, abs=1)


def test_each_parameter_costs_the_same_up_to_those_of_a_rigid_motion_and_less_beyond():
    assert complexity_penalty(6, 1) == 16.0 + 6 * 4.5
    assert complexity_penalty(9, 1) == 16.0 + 6 * 4.5 + 3 * thresholds.CHI2_PER_FURTHER_PARAMETER
    assert thresholds.CHI2_PER_FURTHER_PARAMETER < thresholds.CHI2_PER_PARAMETER


def test_the_best_of_more_shapes_costs_twice_the_logarithm_of_their_number():
    assert complexity_penalty(2, 50) - complexity_penalty(2, 1) == pytest.approx(2 * np.log(50))


def test_posterior_weights_are_those_of_gaussian_likelihoods_and_add_up_to_one():
    weights = posterior_weights(np.array([100.0, 102.0, 120.0]))
    assert weights.sum() == pytest.approx(1.0)
    assert weights[0] / weights[1] == pytest.approx(np.e)
    np.testing.assert_allclose(posterior_weights(np.array([1e6, 1e6 + 2.0])), [1 / (1 + 1 / np.e), 1 / (1 + np.e)])


def test_an_unmodelled_cause_starts_with_odds_of_one_to_four_hundred():
    price = thresholds.CHI2_OF_UNMODELLED_CAUSE
    assert posterior_weights(np.array([0.0, price]))[1] == pytest.approx(1 / 404, rel=0.01)
    assert posterior_weights(np.array([1e9, price])).tolist() == [0.0, 1.0]


def test_credibility_is_halved_where_a_twentieth_of_what_an_effect_explains_is_left():
    assert credibility(0.0, 0.0, 1000.0) == 1.0
    assert credibility(0.0, thresholds.SMALL_SHARE * 1000.0, 1000.0) == 0.5
    assert credibility(0.25, 0.0, 1000.0) == 0.75
    assert credibility(0.0, 100.0, 0.0) < 1.0 - CERTAIN


def test_a_credible_effect_leaves_less_unexplained_than_nearly_half_of_what_it_explains():
    assert credibility(0.0, 0.44 * 1000.0, 1000.0) > 1.0 - CERTAIN
    assert credibility(0.0, 0.46 * 1000.0, 1000.0) < 1.0 - CERTAIN


def test_noise_alone_is_no_gap():
    assert judge(CLEAN) == "no_gap"


def test_a_gap_above_the_noise_for_certain_is_a_gap_however_well_chi_squared_is() -> None:
    assert judge(with_gap(CLEAN, 1.3e-4, 1.1e-4)) == "unexplained"
    assert judge(with_gap(EXPLAINED, 1.3e-4, 1.1e-4, before_m=3e-4)) == "unexplained"


def test_a_gap_near_the_noise_or_that_chance_may_make_is_none() -> None:
    assert judge(with_gap(CLEAN, 1.09e-4, 1.05e-4)) == "no_gap"
    assert judge(with_gap(CLEAN, 1.3e-4, 0.99e-4)) == "no_gap"
    assert judge(with_gap(CLEAN, 1.3e-4, 1.1e-4, expected_m=1.15e-4)) == "no_gap"


def test_rotations_above_the_noise_are_a_gap_only_where_chance_does_not_make_them() -> None:
    assert judge(turned(1.2, 0.95)) == "no_gap"
    assert judge(turned(1.2, 1.12)) == "unexplained"
    assert judge(turned(1.09, 1.05)) == "no_gap"


def test_effects_that_leave_noise_explain_the_gap():
    assert judge(EXPLAINED) == "explained"


def test_a_site_that_speaks_leaves_a_gap_unexplained():
    assert judge(replace(CLEAN, localized=16.0)) == "unexplained"


def test_a_remainder_within_five_per_cent_of_what_effects_explain_is_their_form():
    within = thresholds.SMALL_SHARE * EXPLAINED.explained
    assert within == 0.05 * 8000
    assert judge(replace(EXPLAINED, localized=within - 1.0)) == "explained"
    assert judge(replace(EXPLAINED, localized=within + 1.0)) == "unexplained"


def test_such_a_remainder_counts_as_form_only_up_to_a_tenth_above_the_noise_floor():
    remainder = replace(EXPLAINED, localized=100.0)
    assert judge(with_gap(remainder, 1.09e-4)) == "explained"
    assert judge(with_gap(remainder, 1.11e-4)) == "unexplained"
    assert thresholds.NO_DIFFERENCE == 1.1


def test_or_as_long_as_next_to_nothing_of_a_large_gap_is_open():
    remainder = replace(EXPLAINED, localized=100.0)
    limit = np.sqrt(1e-8 + (1.5e-4**2 - 1e-8) / thresholds.OPEN_SHARE)
    assert judge(with_gap(remainder, 1.5e-4, before_m=1.01 * limit)) == "explained"
    assert judge(with_gap(remainder, 1.5e-4, before_m=0.99 * limit)) == "unexplained"


def test_what_stands_far_above_the_noise_is_open_however_large_the_gap_was():
    remainder = replace(EXPLAINED, localized=100.0)
    assert judge(with_gap(remainder, 1.99e-4, before_m=1.0)) == "explained"
    assert judge(with_gap(remainder, 2.01e-4, before_m=1.0)) == "unexplained"


def test_without_effects_no_remainder_is_a_matter_of_form():
    assert judge(replace(CLEAN, explained=1e6, localized=20.0)) == "unexplained"


def test_with_a_hundred_coordinates_chance_speaks_for_a_site_once_in_three_hundred_data_sets():
    assert 1 / p_value(thresholds.CHI2_PER_EFFECT, 100) == pytest.approx(316, abs=2)


def test_the_p_value_of_a_variance_is_half_that_of_chi_squared():
    assert p_value(9.0, 1) == pytest.approx(0.5 * chi2.sf(9.0, 1))
    assert p_value(9.0, 7) == pytest.approx(7 * p_value(9.0, 1))
    assert p_value(0.0, 10) == 1.0


def test_noise_puts_one_row_in_a_million_beyond_the_limit_of_a_gross_error():
    assert chi2.sf(OUTLIER_SIGMA**2, 2) == pytest.approx(2.7e-7, rel=0.05)
    assert chi2.sf(OUTLIER_SIGMA**2, 3) == pytest.approx(1.2e-6, rel=0.05)


def test_a_random_function_of_one_shape_has_the_likelihood_ratio_of_a_variance():
    ratio, size = likelihood_ratio(np.eye(1), SIX[:1])
    assert ratio == pytest.approx(36.0 - 1.0 - np.log(36.0), rel=1e-3)
    assert size == pytest.approx(np.sqrt(35.0), rel=0.15)


def test_a_function_of_many_shapes_pays_for_each():
    few, _ = likelihood_ratio(np.eye(1), SIX[:1])
    many, _ = likelihood_ratio(np.eye(20), SIX[:20])
    assert many < few - 10


def test_chance_has_the_likelihood_ratio_of_a_function_that_is_free_at_each_pose():
    rng = np.random.default_rng(3)
    moves, parameters = rng.uniform(0.5, 2.0, 40), np.linalg.qr(rng.normal(size=(40, 4)))[0]
    residuals = 3.0 * moves * rng.normal(size=40)
    gradient, shared = moves * (residuals - parameters @ (parameters.T @ residuals)), moves[:, None] * parameters
    dense, _ = likelihood_ratio(np.diag(moves**2) - shared @ shared.T, gradient)
    assert dense > 10.0
    assert chance_ratio(gradient, moves**2, shared) == pytest.approx(dense, rel=1e-9)


def test_a_function_is_no_larger_than_is_plausible():
    ratio, size = likelihood_ratio(np.eye(1), SIX[:1], 0.5)
    assert size == 0.5
    assert ratio == pytest.approx(36.0 * 0.25 / 1.25 - np.log(1.25))


@pytest.mark.parametrize(("poses", "worlds", "held"), [(5, 400, 0.86), (12, 400, 0.91), (60, 200, 0.93)])
def test_the_interval_of_few_poses_holds_the_true_gap_nearly_as_often_as_that_of_many(poses, worlds, held):
    pose, hits = np.repeat(np.arange(poses), 3), []
    for seed in range(worlds):
        low, high = interval(np.random.default_rng(seed).standard_normal((len(pose), 3)), pose, seed)
        hits.append(low <= np.sqrt(3.0) <= high)
    assert np.mean(hits) > held
