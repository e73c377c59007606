"""What is taken of many rows is spread over all of them."""

import numpy as np
import pytest

from robolaser.data.subsampling import evenly, rows_of_each


@pytest.mark.parametrize(("count", "most"), [(0, 5), (1, 5), (5, 5), (17, 5), (1000, 7), (3, 10)])
def test_places_are_each_taken_once_and_reach_from_the_first_to_the_last(count: int, most: int) -> None:
    places = evenly(count, most)
    assert len(places) == len(set(places.tolist())) == min(count, most)
    if count:
        assert (places[0], places[-1]) == (0, count - 1)
        assert np.ptp(np.diff(places)) <= 1 if len(places) > 1 else True


def test_each_group_gives_as_many_rows_as_it_may_in_their_order() -> None:
    group = np.random.default_rng(2).integers(0, 9, 300)
    rows = rows_of_each(group, 4)
    assert (np.diff(rows) > 0).all()
    assert np.bincount(group[rows]).tolist() == np.minimum(np.bincount(group), 4).tolist()
