"""A data set is read and written by what its sensor declares."""

from pathlib import Path

import numpy as np
import pytest

from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.loading import load
from robolaser.data.sensor_format import PIXEL, SensorFormat, sensor_format
from robolaser.data.writing import save
from robolaser.errors import DataError
from robolaser.model.sensors import REGISTERED

CORNERS = SensorFormat(
    kind="corner_camera",
    title="camera that sees corners",
    columns={"pixel": PIXEL, "corner": ("column", "row")},
    numbers=2,
    unit="px",
    units={"fx": "px"},
)


def test_a_sensor_of_the_user_is_saved_and_loaded_by_its_declaration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(REGISTERED, "corner_camera", type("CornerCamera", (), {"format": CORNERS}))
    points = Points(np.arange(2), ("a", "b"), pixel=np.eye(2), columns={"corner": np.arange(4.0).reshape(2, 2)})
    poses = Poses(("p", "q"), T_base_flange=np.eye(4)[None].repeat(2, 0))
    save(Dataset("board", poses, points, kind="corner_camera"), tmp_path)
    assert (tmp_path / "points.csv").read_text().splitlines()[0] == "pose,point,u_px,v_px,column,row"
    read = load(tmp_path)
    assert read.format is CORNERS
    np.testing.assert_array_equal(read.points["corner"], points["corner"])
    np.testing.assert_array_equal(read.points["pixel"], np.eye(2))
    assert "xyz" not in read.points


def test_an_array_that_is_not_there_is_named() -> None:
    with pytest.raises(DataError, match=r"points\.csv has no pixel"):
        Points(np.arange(1), ("a",))["pixel"]


def test_an_unknown_kind_is_an_error_that_names_the_likeliest() -> None:
    with pytest.raises(DataError, match=r"\[sensor\] kind: 'strip', expected .*\. Did you mean 'stripe'\?"):
        sensor_format("strip")


def test_a_parameter_has_the_unit_of_its_name_or_of_the_last_part_of_it() -> None:
    assert sensor_format("stripe").unit_of("s_u") == "m/px"
    assert sensor_format("stripe").unit_of("target.phi") == "rad"
    assert CORNERS.unit_of("fx") == "px"
    assert CORNERS.unit_of("k1") == ""
