"""Charts: their records, their scales, and how much of the data they carry."""

import json

import numpy as np
import pytest

from robolaser.report.chart import FAINT, chart, colours, equal_axes, layer, line, quantity, records
from robolaser.report.error_analysis import some_rows
from robolaser.report.scene import magnification


def test_records_are_as_long_as_their_columns_and_carry_no_more_digits_than_are_seen():
    data = records(a=np.array([0.123456789, np.nan, np.inf]), n=np.array([3, 4, 5]), b="x")
    assert [tuple(row.values()) for row in data] == [(0.12346, 3, "x"), (None, 4, "x"), (None, 5, "x")]
    assert records(a=[], b="x") == []


def test_a_specification_may_stand_in_a_script_element_whatever_the_data_are_called():
    made = chart("t", "c", "a", [layer("point", records(x=1.0, name="</script><!-- \u2028"), x=quantity("x", "x"))])
    assert "<" not in made.json
    assert json.loads(made.json)["layer"][0]["data"]["values"][0]["name"] == "</script><!-- \u2028"


def test_the_legend_switches_every_mark_of_a_series():
    colour = colours({"a": "red", "b": "blue"})
    x = quantity("x", "x")
    data = records(x=[1.0, 2.0], series=["a", "b"])
    layers = [layer(line(), data, x=x, color=colour), layer({"type": "area", "opacity": 0.5}, data, x=x, color=colour)]
    spec = chart("t", "c", "a", layers).spec
    assert spec["layer"][0]["params"][0]["bind"] == "legend"
    switched = [spec["layer"][0]["encoding"]["strokeOpacity"], spec["layer"][1]["encoding"]["opacity"]]
    assert [one["condition"] for one in switched] == [
        {"param": spec["layer"][0]["params"][0]["name"], "value": value} for value in (1.0, 0.5)
    ]
    assert [one["value"] for one in switched] == [FAINT, 0.5 * FAINT]


@pytest.mark.parametrize("width", [300, 700])
def test_a_plan_has_one_scale_for_both_axes_and_holds_all_its_points(width):
    places = np.random.default_rng(0).uniform(-3, 5, (50, 2)) * [2.0, 0.7]
    x, y, height = equal_axes(places, ("x [mm]", "y [mm]"))

    def domain(channel):
        scope = {"width": width, "max": max}
        return [eval(channel["scale"][end]["expr"], scope) for end in ("domainMin", "domainMax")]

    (left, right), (low, high) = domain(x), domain(y)
    assert (right - left) / width == pytest.approx((high - low) / height)
    assert left <= places[:, 0].min()
    assert right >= places[:, 0].max()
    assert low <= places[:, 1].min()
    assert high >= places[:, 1].max()


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
