"""Children are the same to the last bit, whoever makes them."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from robolaser.algorithms import offspring as module
from robolaser.algorithms.offspring import PAYS_AFTER, loop, make_offspring
from robolaser.compiled.loops import SWITCH

LOWER, UPPER = np.array([-1.0, 0.0, 5.0, 2.0, -1e-9]), np.array([1.0, 1e6, 5.5, 2.0, 1e-9])


def arguments(seed, n=8, m=11, outside=0.0, prob=1.0):
    rng = np.random.default_rng(seed)
    room = UPPER - LOWER
    moved = rng.random((2 * n, 5)) < rng.random()
    h = np.count_nonzero(moved)
    return {
        "X": rng.uniform(LOWER - outside * room, UPPER + outside * room, (m, 5)),
        "weights": rng.random(m) ** 8 * (rng.random(m) < 0.8) + 1e-300,
        "at": rng.random((n, 2)),
        "crossed": rng.random(n) < 0.6,
        "share": rng.random(n),
        "moved": moved,
        "upward": rng.random(h) < 0.5,
        "steps": rng.random(h),
        "draws": rng.random(2 * n),
        "prob": prob,
        "lower": LOWER,
        "upper": UPPER,
    }


@pytest.mark.parametrize("outside", [0.0, 0.3], ids=["within bounds", "beyond bounds"])
@pytest.mark.parametrize("prob", [1.0, 0.6, 0.0])
def test_a_compiled_loop_makes_the_same_children(outside, prob):
    compiled = pytest.importorskip("robolaser.algorithms.offspring_loops").make_offspring
    for seed in range(200):
        given = arguments(seed, n=int(1 + seed % 9), outside=outside, prob=prob)
        assert np.array_equal(make_offspring(**given), compiled(*given.values()))


def test_children_stay_within_bounds():
    for seed in range(50):
        Y = make_offspring(**arguments(seed, outside=0.3))
        assert np.all((Y >= LOWER) & (Y <= UPPER))


def test_children_who_neither_mix_nor_move_are_their_parents():
    given = arguments(1) | {"crossed": np.zeros(8, bool), "moved": np.zeros((16, 5), bool)}
    given |= {"upward": np.zeros(0, bool), "steps": np.zeros(0)}
    for child in make_offspring(**given):
        assert (child == given["X"]).all(axis=1).any()


def test_without_luck_no_gene_moves():
    given = arguments(2, prob=0.0)
    still = make_offspring(**given)
    assert np.array_equal(still, make_offspring(**given | {"steps": np.ones(np.count_nonzero(given["moved"]))}))


def test_a_long_run_is_compiled_and_a_short_one_does_not_wait_for_it(monkeypatch):
    pytest.importorskip("numba")
    monkeypatch.delenv(SWITCH, raising=False)
    monkeypatch.delitem(sys.modules, "numba", raising=False)
    monkeypatch.setattr(
        module, "_LOOPS", SimpleNamespace(after=lambda work: SimpleNamespace(make_offspring="compiled"))
    )
    assert loop(1) is loop(PAYS_AFTER) is make_offspring
    assert loop(PAYS_AFTER + 1) == "compiled"


def test_without_a_compiler_children_are_made_in_numpy(monkeypatch):
    monkeypatch.setenv(SWITCH, "0")
    assert loop(PAYS_AFTER + 1) is make_offspring


def test_the_algorithm_does_not_load_the_compiler():
    code = "import sys, robolaser.algorithms.rcga; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
