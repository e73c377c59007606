"""A viewer's scene stays whole, however fast and from how many sides it is asked for, and it says nothing."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scanned import calibrated as made
from scanned import dataset

from robolaser.report.cell_poses import CellPoses
from robolaser.report.viewer.cells import nominal_cell
from robolaser.report.viewer.serving import ViewerApp

pytest.importorskip("viser")
pytestmark = [
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]


@pytest.fixture(scope="module")
def app():
    data = dataset(poses=8)
    calibration = made(data, ["joint_offset:joint_2"], {"joint_offset.joint_2.offset": 0.15})
    served = ViewerApp((nominal_cell(data), CellPoses(calibration.model, calibration.x)))
    yield served
    served.stop()


def test_a_hail_of_changes_from_many_threads_ends_where_the_last_one_says(app):
    rng = np.random.default_rng(0)
    changes = [
        (app._number, lambda: int(rng.integers(8))),
        (app._model, lambda: str(rng.choice(["nominal", "calibrated"]))),
        (app._sliders[1], lambda: float(rng.uniform(-20, 20))),
        (app._shown["robot"], lambda: bool(rng.integers(2))),
    ]
    plan = [(handle, pick()) for _ in range(40) for handle, pick in changes]

    def change(what):
        handle, value = what
        handle.value = value

    with ThreadPoolExecutor(8) as threads:
        list(threads.map(change, plan))
    app._shown["robot"].value = True
    app._model.value = "calibrated"
    app._number.value = 3
    model, handles = app._current, app._handles
    assert model.name == "calibrated"
    assert all(handle.visible for handle in handles.values())
    flange = model.at_pose(3).flange[:3, 3]
    starts = handles["robot/flange"].points[:, 0]
    np.testing.assert_allclose(starts, flange[None].repeat(len(starts), 0), atol=1e-6)
    assert app._hears_sliders
    assert app._pose == 3


def test_a_viewer_starts_and_stops_in_silence(capfd):
    """So that `robolaser view --json` prints JSON alone."""
    ViewerApp((nominal_cell(dataset(poses=4)),)).stop()
    assert capfd.readouterr().out == ""
