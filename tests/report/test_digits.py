"""How numbers are written for people."""

import numpy as np
import pytest

from robolaser.report.digits import human, measured, millimetre_interval, plain, times


@pytest.mark.parametrize(
    ("value", "std", "unit", "said"),
    [
        (0.0072513, 2.1e-6, "m", "7.2513 ± 0.0021 mm"),
        (0.1, np.nan, "m", "100 mm"),
        (np.pi / 6, np.pi / 1800, "rad", "30.00 ± 0.10 °"),
        (np.pi / 6, np.nan, "rad", "30°"),
        (-1.2345, 0.34, "m", "-1230 ± 340 mm"),
        (6.2e-4, 3e-5, "", "0.000620 ± 0.000030"),
        (6.2e-9, 3e-10, "", "(6.20 ± 0.30) × 10⁻⁹"),
        (0.0, 0.0, "px", "0 px"),
        (0.1, 0.0996, "px", "0.10 ± 0.10 px"),
        (0.251922552860105542, 3.1e-17, "", "0.2519226"),
        (-1e-9, 1e-4, "m", "0.00 ± 0.10 mm"),
    ],
)
def test_digits_follow_the_error(value, std, unit, said):
    assert measured(value, std, unit) == said


def test_a_written_value_is_within_a_tenth_of_its_error_of_the_value():
    rng = np.random.default_rng(0)
    for _ in range(300):
        value, std = rng.normal() * 10.0 ** rng.integers(-6, 3), 10.0 ** rng.uniform(-8, 2)
        std = max(std, 1e-6 * abs(value))
        text = measured(value, std, "px").replace("(", "").replace(")", "")
        body, _, power = text.removesuffix(" px").partition(" × 10")
        shown = [float(part) for part in body.split(" ± ")]
        scale = 10.0 ** int(power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or 0)
        assert abs(shown[0] * scale - value) <= 0.1 * std
        assert shown[1] * scale == pytest.approx(std, rel=0.06)


@pytest.mark.parametrize(
    ("value", "unit", "said"), [(0.008, "m", "8 mm"), (7.4e-6, "m/px", "7.4 µm/px"), (0.0, "rad", "0°")]
)
def test_bounds_are_written_shortly(value, unit, said):
    assert plain(value, unit) == said


def test_units_that_nobody_reads_otherwise_stay():
    assert human(2.5, "furlong") == (2.5, "furlong")


def test_ratios_have_one_decimal_until_it_no_longer_matters():
    assert (times(1.26), times(9.96), times(49.6)) == ("1.3", "10", "50")


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [
        (1e-4, 1.22e-4, "0.100 to 0.122 mm"),
        (9.96e-5, 1.1649e-4, "0.100 to 0.116 mm"),
        (0.0, 2e-3, "0.00 to 2.00 mm"),
        (0.11, 0.123456, "110 to 123 mm"),
        (0.0, 0.0, "0 to 0 mm"),
    ],
)
def test_both_ends_of_an_interval_have_the_same_decimals(low, high, said):
    assert millimetre_interval(low, high) == said
