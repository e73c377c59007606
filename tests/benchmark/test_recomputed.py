"""What is printed can be computed again from the exported tables, with SciPy."""

from io import StringIO

import numpy as np
import pandas as pd
import pytest
from made_up import BUDGET, made_up_comparison
from scipy.stats import mannwhitneyu, wilcoxon

from robolaser.benchmark.fixed import fixed_budget, fixed_target
from robolaser.benchmark.result_arrays import HEADLINE
from robolaser.benchmark.result_files import runs_csv
from robolaser.benchmark.standings import standings
from robolaser.benchmark.statistics import signed_rank
from robolaser.benchmark.statistics.profiles import data_profile, performance_profile, performance_ratios

PROBLEMS = ("one", "two", "three", "four", "five", "six")


@pytest.fixture(scope="module")
def result():
    return made_up_comparison({"quick": 1.3, "slow": 1.0, "slower": 0.02}, seeds=7, problems=PROBLEMS)


@pytest.fixture(scope="module")
def table(result):
    return pd.read_csv(StringIO(runs_csv(result)))


def test_running_times_to_a_target_are_what_runs_paid_over_those_that_got_there(result, table):
    for row in fixed_target(result, "calibration", [1.0, HEADLINE]).itertuples():
        rows = table[(table.problem == row.problem) & (table.algorithm == row.algorithm)]
        rows = rows[np.isclose(rows.tolerance, row.tolerance)]
        hits = rows.reached == "yes"
        assert (row.runs, row.successes) == (len(rows), hits.sum())
        paid = np.where(hits, rows.evaluations, rows.run_evaluations).sum()
        assert row.ert == pytest.approx(paid / hits.sum() if hits.any() else np.inf)


def test_costs_at_the_whole_budget_are_those_that_runs_end_with(result):
    ends = result.to_frame().groupby(["problem", "algorithm"]).excess
    found = fixed_budget(result, [BUDGET]).set_index(["problem", "algorithm"])
    pd.testing.assert_series_equal(found["median"].sort_index(), ends.median(), check_names=False)


def test_costs_never_rise_with_the_budget(result):
    found = fixed_budget(result, [10, 100, 1000, BUDGET])
    assert (found.lower <= found["median"]).all()
    assert all(
        np.all(np.diff(of["median"]) <= 0) for _, of in found.replace(np.inf, 1e99).groupby(["problem", "algorithm"])
    )


def test_p_on_a_problem_is_that_of_scipys_mann_whitney_test_on_the_table(result, table):
    at = table[np.isclose(table.tolerance, HEADLINE)]
    for on in standings(result, "calibration").by_problem:
        for pair in on.evaluations.pairs:
            one, other = (at[(at.problem == on.problem) & (at.algorithm == name)] for name in (pair.one, pair.other))
            costs = [
                np.where(runs.reached == "yes", runs.evaluations, 1e9 * (1 + runs.run_best)) for runs in (one, other)
            ]
            tied = len(set(np.concatenate(costs))) < sum(map(len, costs))
            assert pair.p == pytest.approx(mannwhitneyu(*costs, method="asymptotic" if tied else "exact").pvalue)


def test_without_a_rope_the_mean_share_is_wilcoxons_statistic_over_its_largest_value():
    differences = np.random.default_rng(3).normal(0.1, 1.0, 400)
    mean = signed_rank.shares(differences, np.random.default_rng(1), rope=0.0, samples=400).mean(axis=0)
    largest = len(differences) * (len(differences) + 1) / 2
    assert mean[0] == pytest.approx(wilcoxon(differences, alternative="greater").statistic / largest, abs=0.01)


@pytest.mark.parametrize(("shift", "likely"), [(0.4, 0), (0.0, 1), (-0.4, 2)])
def test_who_is_ahead_on_all_problems_is_probably_better_and_tiny_leads_are_none(shift, likely):
    differences = shift + np.random.default_rng(1).uniform(-0.02, 0.02, 10)
    shares = signed_rank.shares(differences, np.random.default_rng(1))
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)
    assert (shares.argmax(axis=1) == likely).mean() > 0.99


def test_probabilities_of_a_pair_name_the_one_that_is_better(result):
    of = signed_rank.signed_rank(result.arrays("calibration")).set_index(["algorithm", "other"])
    assert of.loc[("quick", "slower"), "better"] > 0.99
    np.testing.assert_allclose(of[["better", "alike", "worse"]].sum(axis=1), 1.0)


def test_a_performance_profile_begins_with_who_is_fastest_and_ends_with_what_is_solved():
    expected = np.array([[10.0, 20.0], [5.0, np.inf], [np.inf, np.inf], [8.0, 4.0]])[..., None]
    np.testing.assert_allclose(
        performance_profile(expected, np.array([1.0, 2.0, 100.0])), [[2 / 3, 1, 1], [1 / 3, 2 / 3, 2 / 3]]
    )
    assert np.isnan(performance_ratios(expected)[2]).all()


def test_a_data_profile_counts_in_simplex_gradients():
    times = np.array([[[[30.0]]], [[[30.0]]]])
    np.testing.assert_allclose(data_profile(times, np.array([2, 9]), np.array([2.9, 3.0, 10.0])), [[0, 0.5, 1]])
