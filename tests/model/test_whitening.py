"""Whitening, on its way there and back, of as many candidates as there are: one, many or none."""

import numpy as np
import pytest

from robolaser.model.noise.covariance import Whitener

M, K = 12, 2


@pytest.mark.parametrize("group", [np.arange(M) // 3, np.repeat([0, 1], [5, 7])], ids=["alike", "of other sizes"])
@pytest.mark.parametrize("candidates", [0, 1, 3])
def test_any_number_of_candidates_is_whitened(group: np.ndarray, candidates: int) -> None:
    rng = np.random.default_rng(0)
    whitener = Whitener.of(np.tile(np.eye(K), (M, 1, 1)), [(rng.normal(size=(M, K, 2)), group)])
    batch = rng.normal(size=(candidates, M * K))
    assert whitener(batch).shape == batch.shape
    assert whitener.back(batch).shape == batch.shape
    for there, one in zip(whitener(batch), batch, strict=True):
        np.testing.assert_allclose(there, whitener(one[None])[0], atol=1e-12)


def test_the_precision_of_rows_that_move_is_that_of_their_whitened_motions() -> None:
    rng = np.random.default_rng(1)
    levels = [(rng.normal(size=(M, K, 1)), np.arange(M) // 2), (rng.normal(size=(M, K, 3)), np.arange(M) // 6)]
    whitener, moves = Whitener.of(np.tile(0.5 * np.eye(K), (M, 1, 1)), levels), rng.normal(size=(M, K))
    whitened = whitener(np.eye(M)[:, :, None] * moves)
    own, shared = whitener.precision(moves)
    found = np.diag(own)
    for C, rows in shared:
        found = found - (C @ C.T) * (rows.group[:, None] == rows.group)
    np.testing.assert_allclose(found, whitened @ whitened.T, atol=1e-12)
