"""An installed package announces a sensor, and data sets of its kind are read."""

import os
import subprocess
import sys
from pathlib import Path

from installed import installed

MODULE = """
from robolaser.data.sensor_format import SensorFormat
from robolaser.model.sensors import Sensor

class Scale(Sensor):
    format = SensorFormat(kind="scale", title="weighing scale", columns={})
"""
COMPLETE = "    parameters = residuals = row_errors = None\n"
ASK = "from robolaser.model.sensors import sensors; from robolaser.data.sensor_format import sensor_format; "


def asked(tmp_path: Path, body: str) -> subprocess.CompletedProcess[str]:
    """The kinds that a process knows where a package announces a class with this body."""
    installed(tmp_path, "scales", MODULE + body, "[robolaser.sensors]\nscale = scales:Scale\n")
    path = os.pathsep.join([str(tmp_path), *sys.path])
    return subprocess.run(
        [sys.executable, "-c", ASK + "print(sensor_format('scale').title); print(*sensors())"],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )


def test_its_kind_is_known_beside_ours(tmp_path: Path) -> None:
    title, kinds = asked(tmp_path, COMPLETE).stdout.splitlines()
    assert title == "weighing scale"
    assert sorted(kinds.split()) == ["camera", "point", "pose", "profile", "scale", "socket", "stripe"]


def test_one_that_lacks_methods_is_refused_with_the_packages_name(tmp_path: Path) -> None:
    said = asked(tmp_path, "    pass").stderr
    assert "The installed package scales announces scales:Scale under robolaser.sensors" in said
    assert "it does not define parameters, residuals, row_errors" in said
