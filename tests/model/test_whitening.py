"""Rows that belong together, side by side and back; whitening of them, for as many candidates as there are."""

import numpy as np
import pytest

from robolaser.model.grouped_rows import GroupedRows
from robolaser.model.noise.covariance import GroupStage, Whitener

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


ALIKE, UNEVEN, UNORDERED = [0, 0, 1, 1, 2, 2], [0, 1, 1, 1, 3, 3], [2, 0, 1, 0, 2, 2]


@pytest.mark.parametrize("group", [ALIKE, UNEVEN, UNORDERED])
def test_rows_come_back_as_they_went(group: list[int]) -> None:
    rows = np.random.default_rng(0).standard_normal((len(group), 2, 3))
    grouped = GroupedRows(np.array(group))
    np.testing.assert_array_equal(grouped.together(grouped.apart(rows)), rows)


@pytest.mark.parametrize("group", [ALIKE, UNEVEN, UNORDERED])
def test_sums_over_groups_are_those_of_their_rows(group: list[int]) -> None:
    rows, number = np.random.default_rng(1).standard_normal((len(group), 2)), np.array(group)
    each = np.array([rows[number == one].sum(axis=0) for one in range(number.max() + 1)])
    np.testing.assert_allclose(GroupedRows(number).apart(rows).sum(axis=1), each)


@pytest.mark.parametrize("shared_errors", [1, 9])
@pytest.mark.parametrize("group", [ALIKE, UNEVEN, UNORDERED])
def test_shared_errors_are_white_afterwards(group: list[int], shared_errors: int) -> None:
    shared, m = np.random.default_rng(2).standard_normal((len(group), 2, shared_errors)), len(group)
    together = np.repeat(np.equal.outer(group, group), 2, axis=0).repeat(2, axis=1)
    flat = shared.reshape(2 * m, -1)
    covariance = np.eye(2 * m) + flat @ flat.T * together
    W = GroupStage(shared, np.array(group))(np.eye(2 * m).reshape(m, 2, -1)).reshape(2 * m, -1)
    np.testing.assert_allclose(W @ covariance @ W.T, np.eye(2 * m), atol=1e-12)
