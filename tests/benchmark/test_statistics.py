import numpy as np
import pytest
from scipy import stats

from robolaser.benchmark.result import outcomes
from robolaser.benchmark.statistics import difference, running_time
from robolaser.benchmark.statistics.intervals import wilson


def _rare(count: int, trials: int, probability: float) -> bool:
    """Is that more than chance would have it, once in ten thousand times?"""
    return bool(stats.binom.sf(count - 1, trials, probability) < 1e-4)


# success


def test_without_runs_no_share_is_known():
    assert wilson(0, 0).value is None
    assert wilson(1, 2).value == 0.5


# expected running time


def test_running_time_of_runs_that_all_succeed_is_their_mean():
    running_times = np.random.default_rng(0).exponential(100, 7)
    assert running_time.expected(running_times, running_times + 5) == pytest.approx(running_times.mean())


def test_running_time_pays_for_failures_and_counts_successes():
    assert running_time.expected(np.array([100.0, np.inf, 300.0]), np.array([900.0, 1000.0, 900.0])) == 700.0


def test_a_target_nobody_reached_takes_for_ever_and_without_runs_nothing_is_known():
    assert running_time.expected(np.array([np.inf]), np.array([100.0])) == np.inf
    assert np.isnan(running_time.expected(np.array([np.nan]), np.array([np.nan])))


def test_a_ratio_turned_round_is_its_inverse():
    ratios = running_time.mean_ratios(np.random.default_rng(4).exponential(100, (2, 3)))
    assert ratios * ratios.T == pytest.approx(1.0)


def test_the_mean_ratio_is_geometric_and_leaves_out_problems_that_either_did_not_solve():
    expected = np.array([[10.0, 20.0, np.inf], [10.0, 80.0, np.inf], [10.0, np.inf, np.nan]])
    assert running_time.mean_ratios(expected)[0, 1] == pytest.approx(4.0)
    assert np.isnan(running_time.mean_ratios(expected)[0, 2])


# traces and quality


def test_an_ecdf_never_falls_and_ends_at_the_share_of_targets_that_were_reached():
    rng = np.random.default_rng(6)
    running_times = rng.exponential(100, (3, 2, 5, 4))
    running_times[rng.random(running_times.shape) < 0.4] = np.inf
    spent = np.full((3, 2, 5), 2000.0)
    budgets = running_time.budgets(running_times, spent)
    shares = running_time.shares(running_times, budgets)
    assert (np.diff(shares, axis=1) >= 0).all()
    assert shares[:, -1] == pytest.approx(np.isfinite(running_times).mean(axis=(0, 2, 3)))


def test_runs_that_are_not_there_do_not_count_in_an_ecdf():
    running_times = np.array([1.0, np.inf, np.nan, np.nan]).reshape(1, 2, 2, 1)
    assert running_time.shares(running_times, np.array([5.0]))[0, 0] == 0.5
    assert np.isnan(running_time.shares(running_times, np.array([5.0]))[1, 0])
    assert not len(running_time.budgets(np.full((1, 1, 1, 1), np.inf), np.ones((1, 1, 1))))


# outcomes


def test_who_reaches_the_target_comes_before_who_does_not_and_who_finds_nothing_comes_last():
    running_times = np.array([[[50.0, np.inf, 20.0], [np.inf, np.inf, np.nan]]])
    final = np.array([[[0.001, 3.0, 0.009], [0.5, np.inf, np.nan]]])
    assert outcomes(running_times, final).tolist()[0][0] == [2, 4, 1]
    assert outcomes(running_times, final)[0, 1, :2].tolist() == [3, 5]
    assert np.isnan(outcomes(running_times, final)[0, 1, 2])


def test_equal_runs_share_a_place():
    assert outcomes(np.full((1, 2, 3), np.inf), np.full((1, 2, 3), np.inf)).tolist() == [[[1, 1, 1], [1, 1, 1]]]


# effect size


def test_superiority_turned_round_is_what_is_left_to_one():
    x = np.random.default_rng(10).integers(0, 8, (3, 4, 9)).astype(float)
    found = difference.superiority(x)
    assert found + found.T == pytest.approx(1.0)


def test_superiority_is_mann_and_whitneys_u_per_pair_of_runs():
    x = np.random.default_rng(11).normal(size=(1, 2, 12))
    u = stats.mannwhitneyu(x[0, 1], x[0, 0]).statistic
    assert difference.superiority(x)[0, 1] == pytest.approx(u / 144)


def test_superiority_over_several_problems_is_the_mean_of_those_with_runs_of_both():
    x = np.array([[[1.0, 2.0], [3.0, 4.0]], [[1.0, 4.0], [2.0, 3.0]], [[1.0, 2.0], [np.nan, np.nan]]])
    assert difference.superiority(x)[0, 1] == pytest.approx((1.0 + 0.5) / 2)
    assert np.isnan(difference.superiority(x[2:])[0, 1])


# tests


def test_rank_sums_are_scipys():
    x = np.random.default_rng(13).normal(size=(2, 3, 7))
    p = difference.rank_sum(x)
    assert p[1, 0, 2] == p[1, 2, 0] == stats.mannwhitneyu(x[1, 0], x[1, 2], method="exact").pvalue
    assert np.isnan(p[:, [0, 1, 2], [0, 1, 2]]).all()


def test_on_one_problem_the_stratified_test_is_the_plain_one():
    x = np.random.default_rng(14).normal(size=(1, 3, 7))
    assert difference.stratified(x) == pytest.approx(difference.rank_sum(x)[0], nan_ok=True)


def test_small_differences_on_many_problems_add_up():
    x = np.random.default_rng(15).normal(size=(6, 2, 12)) + np.array([0, 0.7])[:, None]
    assert difference.stratified(x)[0, 1] < difference.rank_sum(x)[:, 0, 1].min()


def test_what_is_all_tied_cannot_be_told_apart():
    assert difference.stratified(np.ones((3, 2, 5)))[0, 1] == 1.0
    assert difference.rank_sum(np.ones((3, 2, 5)))[0, 0, 1] == 1.0


def test_without_runs_there_is_no_test():
    x = np.full((2, 2, 3), np.nan)
    x[:, 0] = 1.0
    assert np.isnan(difference.stratified(x)).all()
    assert np.isnan(difference.holm_pairs(difference.rank_sum(x))).all()


@pytest.mark.parametrize(("problems", "runs"), [(1, 4), (1, 9), (2, 3), (5, 1), (5, 2), (5, 6)])
def test_where_there_is_no_difference_the_stratified_test_finds_one_in_twenty_at_most(problems, runs):
    x = np.random.default_rng(16).random((400, problems, 2, runs))
    found = sum(difference.stratified(one)[0, 1] < 0.05 for one in x)
    tied = sum(difference.stratified(np.round(3 * one))[0, 1] < 0.05 for one in x)
    assert not _rare(found, 400, 0.05)
    assert not _rare(tied, 400, 0.05)


def test_where_nobody_differs_one_comparison_in_twenty_at_most_says_that_anybody_does():
    p = difference.rank_sum(np.random.default_rng(17).random((400, 4, 6))).reshape(200, 2, 4, 4)
    chosen = p[np.nanmin(p, axis=(1, 2, 3)) < 0.01]  # no others can be below 0.05 after correction for 12
    found = sum((difference.holm_pairs(one) < 0.05).any() for one in chosen)
    assert not _rare(int(found), 200, 0.05)


def test_holms_correction_never_lowers_p_and_keeps_their_order():
    p = np.random.default_rng(18).random(30) ** 3
    p[4] = np.nan
    adjusted = difference.holm(p)
    there = ~np.isnan(p)
    assert (adjusted[there] >= p[there]).all()
    assert (np.diff(adjusted[there][np.argsort(p[there])]) >= 0).all()
    assert adjusted[np.nanargmin(p)] == pytest.approx(29 * np.nanmin(p))
    assert np.isnan(adjusted[4])


def test_holm_corrects_for_pairs_that_are_all_tied_too():
    x = np.array([[np.ones(6), np.ones(6), np.arange(6.0) + 2]])
    p = difference.rank_sum(x)
    assert p[0, 0, 1] == 1.0
    assert difference.holm_pairs(p)[0, 0, 2] == pytest.approx(3 * p[0, 0, 2])


def test_the_smallest_p_there_is_falls_with_runs_and_problems():
    assert difference.smallest(4, 1) == pytest.approx(2 / 70)
    assert difference.smallest(4, 3) < difference.smallest(4, 1)
    assert difference.smallest(1, 1) == 1.0
