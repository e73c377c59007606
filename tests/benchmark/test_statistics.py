import numpy as np
import pytest
from scipy import stats

from robolaser.benchmark.result import outcomes
from robolaser.benchmark.statistics import difference, running_time
from robolaser.benchmark.statistics.intervals import Intervals, wilson


def _none(bounded: Intervals) -> bool:
    return bool(np.isnan(bounded.lower).all() and np.isnan(bounded.upper).all())


def _rare(count: int, trials: int, probability: float) -> bool:
    """Is that more than chance would have it, once in ten thousand times?"""
    return bool(stats.binom.sf(count - 1, trials, probability) < 1e-4)


def test_without_runs_no_share_is_known():
    assert wilson(0, 0).value is None
    assert wilson(1, 2).value == 0.5


def _expected(running_times, totals):
    """ERT of the runs of one algorithm on one problem."""
    return running_time.expected(np.array([[running_times]]), np.array([[totals]]))[0, 0, 0]


def test_running_time_of_runs_that_all_succeed_is_their_mean():
    running_times = np.random.default_rng(0).exponential(100, 7)
    assert _expected(running_times, running_times + 5) == pytest.approx(running_times.mean())


def test_running_time_pays_for_failures_and_counts_successes():
    assert _expected([100.0, np.inf, 300.0], [900.0, 1000.0, 900.0]) == 700.0


def test_a_target_nobody_reached_takes_for_ever_and_without_runs_nothing_is_known():
    assert _expected([np.inf], [100.0]) == np.inf
    assert np.isnan(_expected([np.nan], [np.nan]))


def _intervals(running_times, spent):
    """ERT with its interval to one target, (p, a, s) -> (p, a); the ratios on each problem, and their means."""
    found = running_time.expected(running_times, spent)
    runs = np.full(found.shape[:2], running_times.shape[2])
    alone = [running_time.mean_ratios(found[[i]], runs[[i]]) for i in range(len(found))]
    ratios = Intervals(*(np.array([getattr(one, name) for one in alone]) for name in ("value", "lower", "upper")))
    return running_time.bounded(found, runs, runs - 1), ratios, running_time.mean_ratios(found, runs)


@pytest.mark.parametrize("success", [1.0, 0.7])
def test_a_planted_ratio_of_three_is_inside_its_interval_nineteen_times_in_twenty(success):
    rng = np.random.default_rng(2)
    running_times = rng.exponential(100, (400, 2, 10))
    reached = rng.random(running_times.shape) < success
    spent = np.where(reached, running_times, 300.0) * np.array([1, 3])[:, None]
    _, ratios, _ = _intervals(np.where(reached, spent, np.inf), spent)
    inside = int(((ratios.lower[:, 0, 1] <= 3) & (ratios.upper[:, 0, 1] >= 3)).sum())
    assert not _rare(400 - inside, 400, 0.06)
    assert not _rare(inside, 400, 0.97)


def test_the_mean_ratio_over_problems_is_inside_its_interval_too():
    rng = np.random.default_rng(3)
    spent = rng.exponential(100, (150, 3, 2, 6)) * np.array([1, 10, 100])[:, None, None] * np.array([1, 3])[:, None]
    inside = 0
    for of_problems in spent:
        _, _, mean = _intervals(of_problems, of_problems)
        assert mean.lower[0, 1] <= mean.value[0, 1] <= mean.upper[0, 1]
        inside += bool(mean.lower[0, 1] <= 3 <= mean.upper[0, 1])
    assert not _rare(150 - inside, 150, 0.06)


def test_a_ratio_turned_round_is_its_inverse():
    running_times = np.random.default_rng(4).exponential(100, (2, 3, 8))
    _, ratios, mean = _intervals(running_times, running_times)
    for of in (ratios, mean):
        others = ~np.eye(3, dtype=bool)
        assert (of.value * np.swapaxes(of.value, -1, -2))[..., others] == pytest.approx(1.0)
        assert (of.lower * np.swapaxes(of.upper, -1, -2))[..., others] == pytest.approx(1.0)


def test_the_mean_ratio_is_geometric_and_leaves_out_problems_that_either_did_not_solve():
    running_times = np.array([[[10.0] * 6, [20.0] * 6], [[10.0] * 6, [80.0] * 6], [[10.0] * 6, [np.inf] * 6]])
    _, ratios, mean = _intervals(running_times, np.where(np.isfinite(running_times), running_times, 100.0))
    assert mean.value[0, 1] == pytest.approx(4.0)
    assert np.isnan(ratios.value[2, 0, 1])


def test_where_successes_are_rare_the_running_time_has_no_upper_bound():
    running_times = np.full((1, 1, 10), np.inf)
    running_times[0, 0, 3] = 50.0
    interval, _, _ = _intervals(running_times, np.where(np.isfinite(running_times), running_times, 100.0))
    assert interval.upper[0, 0] == np.inf
    assert interval.value[0, 0] == 950.0


def test_too_few_runs_have_no_interval():
    running_times = np.random.default_rng(5).exponential(100, (1, 2, 4))
    interval, ratios, _ = _intervals(running_times, running_times)
    assert _none(interval)
    assert _none(ratios)


def test_an_ecdf_never_falls_and_ends_at_the_share_of_targets_that_were_reached():
    rng = np.random.default_rng(6)
    running_times = rng.exponential(100, (3, 2, 5, 4))
    running_times[rng.random(running_times.shape) < 0.4] = np.inf
    budgets = running_time.budgets(running_times, np.full((3, 2, 5), 2000.0))
    shares = running_time.shares(running_times, budgets)
    assert (np.diff(shares, axis=1) >= 0).all()
    assert shares[:, -1] == pytest.approx(np.isfinite(running_times).mean(axis=(0, 2, 3)))


def test_runs_that_are_not_there_do_not_count_in_an_ecdf():
    running_times = np.array([1.0, np.inf, np.nan, np.nan]).reshape(1, 2, 2, 1)
    assert running_time.shares(running_times, np.array([5.0]))[0, 0] == 0.5
    assert np.isnan(running_time.shares(running_times, np.array([5.0]))[1, 0])
    assert not len(running_time.budgets(np.full((1, 1, 1, 1), np.inf), np.ones((1, 1, 1))))


def test_who_reaches_the_target_comes_before_who_does_not_and_who_finds_nothing_comes_last():
    running_times = np.array([[[50.0, np.inf, 20.0], [np.inf, np.inf, np.nan]]])
    final = np.array([[[0.001, 3.0, 0.009], [0.5, np.inf, np.nan]]])
    assert outcomes(running_times, final).tolist()[0][0] == [2, 4, 1]
    assert outcomes(running_times, final)[0, 1, :2].tolist() == [3, 5]
    assert np.isnan(outcomes(running_times, final)[0, 1, 2])


def test_equal_runs_share_a_place():
    assert outcomes(np.full((1, 2, 3), np.inf), np.full((1, 2, 3), np.inf)).tolist() == [[[1, 1, 1], [1, 1, 1]]]


def test_superiority_and_its_bounds_turned_round_are_what_is_left_to_one():
    x = np.random.default_rng(10).integers(0, 8, (3, 4, 9)).astype(float)
    for of in (difference.superiority(x[:1]), difference.superiority(x)):
        assert of.value + of.value.T == pytest.approx(1.0)
        assert of.lower + of.upper.T == pytest.approx(1.0)
        assert (of.lower <= of.value).all()


def test_superiority_is_mann_and_whitneys_u_per_pair_of_runs():
    x = np.random.default_rng(11).normal(size=(1, 2, 12))
    u = stats.mannwhitneyu(x[0, 1], x[0, 0]).statistic
    assert difference.superiority(x).value[0, 1] == pytest.approx(u / 144)


@pytest.mark.parametrize("shift", [0.0, 1.5])
def test_superiority_is_inside_its_interval_nineteen_times_in_twenty(shift):
    x = np.random.default_rng(12).normal(size=(500, 2, 8)) + np.array([0, shift])[:, None]
    truth = stats.norm.cdf(shift / np.sqrt(2))
    for problems, trials in ((1, 500), (3, 150)):  # more than 51 and 21 outside would be rare
        trial = x[: problems * trials].reshape(10, trials // 10, problems, 2, 8)
        outside = 0
        for ten in np.moveaxis(trial, 0, 2).reshape(trials // 10, problems, 20, 8):  # a pair depends on no other
            found, even = difference.superiority(ten), np.arange(0, 20, 2)
            lower, upper = (bound[even, even + 1] for bound in (found.lower, found.upper))
            outside += int(((truth < lower) | (truth > upper)).sum())
        assert not _rare(outside, trials, 0.06)


def test_superiority_over_several_problems_is_the_mean_of_those_with_runs_of_both():
    x = np.array([[[1.0, 2.0], [3.0, 4.0]], [[1.0, 4.0], [2.0, 3.0]], [[1.0, 2.0], [np.nan, np.nan]]])
    assert difference.superiority(x).value[0, 1] == pytest.approx((1.0 + 0.5) / 2)
    assert np.isnan(difference.superiority(x[2:]).value[0, 1])


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
    x = np.random.default_rng(16).random((250, problems, 2, runs))
    found = sum(difference.stratified(one)[0, 1] < 0.05 for one in x)
    tied = sum(difference.stratified(np.round(3 * one))[0, 1] < 0.05 for one in x)
    assert not _rare(found, 250, 0.05)
    assert not _rare(tied, 250, 0.05)


def test_where_nobody_differs_one_comparison_in_twenty_at_most_says_that_anybody_does():
    p = difference.rank_sum(np.random.default_rng(17).random((200, 4, 6))).reshape(100, 2, 4, 4)
    chosen = p[np.nanmin(p, axis=(1, 2, 3)) < 0.01]  # no others can be below 0.05 after correction for 12
    assert not _rare(int(sum((difference.holm_pairs(one) < 0.05).any() for one in chosen)), 100, 0.05)


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
    p = difference.rank_sum(np.array([[np.ones(6), np.ones(6), np.arange(6.0) + 2]]))
    assert p[0, 0, 1] == 1.0
    assert difference.holm_pairs(p)[0, 0, 2] == pytest.approx(3 * p[0, 0, 2])


def test_the_smallest_p_there_is_falls_with_runs_and_problems():
    assert difference.smallest(4, 1) == pytest.approx(2 / 70)
    assert difference.smallest(4, 3) < difference.smallest(4, 1)
    assert difference.smallest(1, 1) == 1.0
