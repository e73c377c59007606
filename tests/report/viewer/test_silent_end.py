"""What a viewer prints: nothing, so that `robolaser view --json` prints JSON alone."""

import pytest

from robolaser import find_robot
from robolaser.report.viewer.cell_model import nominal
from robolaser.report.viewer.serving import ViewerApp
from robolaser.simulation import simulate

pytest.importorskip("viser")


def test_a_viewer_starts_and_stops_in_silence(capfd: pytest.CaptureFixture[str]) -> None:
    app = ViewerApp((nominal(simulate(find_robot("ur10"), kind="point", poses=4, seed=1).dataset),), None, None)
    app.stop()
    assert capfd.readouterr().out == ""
