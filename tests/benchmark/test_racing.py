import numpy as np
import pytest
from scipy.stats import friedmanchisquare

from robolaser import RunPlan, compare
from robolaser.benchmark import load
from robolaser.benchmark.racing import survivors
from robolaser.benchmark.setting_space import SettingSpace
from robolaser.cli import main
from robolaser.errors import UsageError


def test_nobody_is_dropped_where_friedmans_test_finds_nothing():
    kept = dropped = 0
    for seed in range(200):
        blocks = np.random.default_rng(seed).normal(0, 1, (8, 4)) + np.array([0, 0.2, 0.4, 0.8])
        if friedmanchisquare(*blocks.T).pvalue >= 0.05:
            assert survivors(blocks).all()
            kept += 1
        else:
            dropped += not survivors(blocks).all()
    assert min(kept, dropped) > 20


def test_among_equals_the_level_is_kept():
    wrong = [not survivors(np.random.default_rng(seed).normal(size=(12, 5))).all() for seed in range(1000)]
    assert 0.01 < np.mean(wrong) < 0.05


def test_one_that_is_far_worse_costs_no_other_its_place():
    """Friedman's test then always finds something: only a correction keeps the level among the others."""
    blocks = [np.random.default_rng(seed).normal(size=(12, 6)) + np.array([0, 0, 0, 0, 0, 9]) for seed in range(500)]
    assert np.mean([not survivors(of)[:5].all() for of in blocks]) < 0.1
    assert not any(survivors(of)[5] for of in blocks)


@pytest.mark.parametrize("blocks", [np.ones((6, 3)), np.empty((0, 2)), np.arange(6.0)[:, None]])
def test_without_a_difference_all_stay(blocks):
    assert survivors(blocks).all()


def test_who_is_last_in_every_block_goes_and_the_best_stays():
    blocks = np.tile([1.0, 2.0, 9.0], (8, 1))
    assert survivors(blocks).tolist() == [True, False, False]


def test_a_race_ends_early_with_the_better():
    found = compare(RunPlan.of(["pymoo:sphere-5"], ["random", "cmaes"], seeds=12, budget=400), race=True)
    assert list(found.dropped) == ["random"]
    assert len(found.runs) == found.wanted == 2 * found.dropped["random"] < 24


def test_lists_give_all_combinations_and_ranges_samples_of_their_kind():
    assert SettingSpace("rcga", ["b=1,2", "pop_size=20,40,60"]).first == (
        "rcga",
        *(f"rcga:b={b}:pop_size={size}" for b in (1, 2) for size in (20, 40, 60)),
    )
    sampled = SettingSpace("GA+crossover=SBX", ["pop_size=10..500", "x=0..1"], samples=50).first[1:]
    assert len(set(sampled)) == 50
    sizes = [int(name.split("pop_size=")[1].split(":")[0]) for name in sampled]
    assert 10 <= min(sizes) < 30 < 250 < max(sizes) <= 500
    assert 40 < np.median(sizes) < 130  # on a logarithmic scale
    assert all(name.endswith("+crossover=SBX") for name in sampled)
    assert SettingSpace("rcga", ["b=0..9"], seed=2).first == SettingSpace("rcga", ["b=0..9"], seed=2).first


def test_later_samples_are_nearer_to_the_best():
    space = SettingSpace("rcga", ["b=0.0..1.0", "c=0.0..1.0"], samples=30)
    best, spread = space.first[1], []
    at = np.array([float(part.split("=")[1]) for part in best.split(":")[1:]])
    for number in (1, 3, 5):
        near = [[float(part.split("=")[1]) for part in name.split(":")[1:]] for name in space.near([best], 30, number)]
        spread.append(np.abs(np.array(near) - at).mean())
    assert spread[0] > 2 * spread[1] > 4 * spread[2]


@pytest.mark.parametrize("text", ["b", "b=", "=3", "b=1,,2", "b=3..1", "b=x..y"])
def test_settings_that_cannot_be_read_are_answered_by_what_was_expected(text):
    with pytest.raises(UsageError, match="pop_size=20,50,100"):
        SettingSpace("rcga", [text])


def test_a_race_of_settings_is_one_line_and_says_whom_it_left(tmp_path, capsys):
    typed = ["--algorithms", "ga", "--vary", "pop_size=4..100", "--samples", "6", "--race", "--seeds", "8"]
    typed = ["compare", "pymoo:sphere-3", *typed, "--budget", "300", "--output", str(tmp_path)]
    assert main(typed) == 0
    assert "The race left" in capsys.readouterr().out
    page, result = (tmp_path / "report.html").read_text(), load(tmp_path)
    assert "dropped from the race after" in page
    assert "runs so far" not in page
    assert len(result.solvers) > 7  # settings near the best came later
    assert set(result.dropped) < set(result.solvers)
    assert main([*typed, "--resume"]) == 0
    assert load(tmp_path).dropped == result.dropped
    assert len(load(tmp_path).runs) == len(result.runs)
