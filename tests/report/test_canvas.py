"""Labels that find room."""

import numpy as np

from robolaser.report.canvas import spread
from robolaser.report.evidence import some_rows
from robolaser.report.pictures.points import magnification


def test_labels_keep_apart_in_order_and_inside():
    rng = np.random.default_rng(1)
    for count in (1, 2, 5, 14):
        wanted = rng.uniform(0, 1, count) ** 3
        placed = np.array(spread(wanted.tolist(), 0.06))
        order = np.argsort(wanted)
        assert (np.diff(placed[order]) >= 0.06 - 1e-9).all()
        assert placed.min() >= -1e-9
        assert placed.max() <= 1 + 1e-9


def test_labels_with_room_stay_where_they_are():
    assert spread([0.9, 0.1, 0.5], 0.06) == [0.9, 0.1, 0.5]


def test_thinning_keeps_the_largest_errors():
    errors = np.random.default_rng(2).exponential(size=5000)
    rows = some_rows(errors, 500)
    assert len(rows) <= 500
    assert np.isin(np.argsort(errors)[-50:], rows).all()


def test_a_magnification_is_one_two_or_five_times_a_power_of_ten():
    for error in np.geomspace(1e-6, 1e-1, 30):
        factor = magnification(error, 0.7)
        assert round(factor / 10 ** np.floor(np.log10(factor) + 1e-9), 6) in (1, 2, 5)
        assert 0.3 < factor * error / (0.08 * 0.7) <= 1.0 + 1e-9
