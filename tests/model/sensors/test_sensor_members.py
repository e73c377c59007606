"""What the author of a sensor may write: few members, and the rest follows."""

import ast
import inspect
import textwrap
from collections.abc import Iterator

import numpy as np
import pytest

from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.sensor_format import SensorFormat
from robolaser.errors import DataError
from robolaser.model.forward_model import Model
from robolaser.model.sensors import sensors
from robolaser.model.sensors.sensor import REGISTERED, Sensor, SensorParameters

MOST = 10


def members() -> Iterator[tuple[str, bool]]:
    """Public members of `Sensor` by name, and whether they are final."""
    (sensor,) = ast.parse(textwrap.dedent(inspect.getsource(Sensor))).body
    for one in sensor.body:
        if isinstance(one, ast.AnnAssign) and isinstance(one.target, ast.Name):
            yield one.target.id, False
        elif isinstance(one, ast.FunctionDef) and not one.name.startswith("_"):
            yield one.name, any(isinstance(mark, ast.Name) and mark.id == "final" for mark in one.decorator_list)


def test_an_author_overrides_at_most_ten_members() -> None:
    assert len([name for name, is_final in members() if not is_final]) <= MOST


def test_four_of_them_must_be_written() -> None:
    assert {"format"} | Sensor.__abstractmethods__ == {"format", "parameters", "residuals", "row_errors"}


@pytest.mark.parametrize("kind", ["camera", "point", "pose", "profile", "socket", "stripe"])
def test_no_sensor_overrides_what_is_final(kind: str) -> None:
    assert not {name for name, is_final in members() if is_final} & set(vars(sensors()[kind]))


def test_free_parameters_without_a_closed_form_must_be_given() -> None:
    class Scale(Sensor):
        format = SensorFormat(kind="scale", title="weighing scale", columns={}, numbers=1, unit="kg")
        parameters = SensorParameters(free=("load", "zero"))
        residuals = row_errors = None

    try:
        points = Points(np.zeros(1, dtype=np.int64), ("a",))
        dataset = Dataset("weighed", Poses(("0",), T_base_flange=np.eye(4)[None]), points, kind="scale")
        with pytest.raises(DataError, match=r"lacks load, zero: a scale sensor needs \{ nominal, lower, upper \}"):
            Model(dataset)
    finally:
        del REGISTERED["scale"]


def test_derived_parameters_need_a_way_to_find_them() -> None:
    class Level(Sensor, registered=False):
        format = SensorFormat(kind="level", title="spirit level", columns={})
        parameters = SensorParameters(derived=("tilt",))
        residuals = row_errors = None

    with pytest.raises(NotImplementedError, match="Level has derived parameters"):
        Level(None).initialize({}, np.eye(4)[None, None], None)
