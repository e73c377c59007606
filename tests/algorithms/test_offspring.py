"""Children keep to their bounds and come from their parents."""

import numpy as np

from robolaser.algorithms.offspring import make_offspring

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
