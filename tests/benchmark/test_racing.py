import numpy as np
import pytest
from scipy.stats import friedmanchisquare

from robolaser.benchmark.racing import race, survivors


def test_nobody_is_dropped_where_friedmans_test_finds_nothing():
    kept = dropped = 0
    for seed in range(200):
        blocks = np.random.default_rng(seed).normal(0, 1, (8, 4)) + np.array([0, 0.2, 0.4, 0.8])
        if friedmanchisquare(*blocks.T).pvalue >= 0.05:
            assert survivors(blocks).all()
            kept += 1
        else:
            assert not survivors(blocks).all()
            dropped += 1
    assert min(kept, dropped) > 20


def test_among_equals_the_level_is_kept():
    wrong = [not survivors(np.random.default_rng(seed).normal(size=(12, 5))).all() for seed in range(1000)]
    assert np.mean(wrong) == pytest.approx(0.05, abs=0.02)


@pytest.mark.parametrize("blocks", [np.ones((6, 3)), np.empty((0, 2)), np.arange(6.0)[:, None]])
def test_without_a_difference_all_stay(blocks):
    assert survivors(blocks).all()


def test_who_is_last_in_every_block_goes_and_the_best_stays():
    blocks = np.tile([1.0, 2.0, 9.0], (8, 1))
    assert survivors(blocks).tolist() == [True, False, False]


def test_a_race_ends_early_with_the_better():
    found = race(["pymoo:sphere-5"], ["random", "cmaes"], seeds=12, budget=400)
    assert found.left == ("cmaes",)
    assert found.runs == 2 * found.dropped["random"] < 24
