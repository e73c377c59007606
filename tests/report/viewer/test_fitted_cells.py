"""What `calibrate` and `diagnose` write is shown, for every sensor that has no laser plane."""

import numpy as np
import pytest
from few_files import only

import robolaser
from robolaser.cli import main
from robolaser.report.viewer.scene import fixed_shapes, moving_shapes

CELLS = [
    ("camera", "flange"),
    ("camera", "base"),
    ("point", None),
    ("pose", None),
    ("socket", None),
    ("profile", "flange"),
]


@pytest.fixture(scope="module", params=CELLS, ids=lambda cell: "-".join(filter(None, cell)))
def saved(request, tmp_path_factory):
    """A data set, and its calibration beside it."""
    kind, mount = request.param
    folder = tmp_path_factory.mktemp(kind)
    typed = [
        "simulate", "--robot", "ur5", "--sensor", kind, "--poses", "12", "--effect",
        "joint_offset:elbow_joint=0.003",
    ]  # fmt: skip
    typed += [*(["--mount", mount] if mount else []), "--pixel-px", "0.2", "--point-m", "3e-5"]
    assert main([*typed, "--output", str(folder / "data"), "--quiet"]) == 0
    with only():
        found = robolaser.calibrate(folder / "data", effects=["joint_offset:elbow_joint"])
    found.save(folder / "result")
    return folder, found


@pytest.fixture
def shown(saved, served):
    """The model that is shown."""
    folder, _ = saved
    assert main(["view", str(folder / "data"), str(folder / "result"), "--no-browser", "--quiet"]) == 0
    (((model,), *_),) = served
    return model


def test_points_are_as_far_from_where_they_are_known_as_the_calibration_says(saved, shown):
    _, found = saved
    apart = np.linalg.norm(shown.points - shown.target, axis=1)
    assert np.sqrt(np.mean(apart**2)) == pytest.approx(found.rms_m, rel=0.02)


def test_the_cell_is_drawn_at_any_pose_and_at_other_angles(shown):
    shapes = [*moving_shapes(shown, shown.at_pose(2)), *fixed_shapes(shown, (shown,))]
    assert {shape.name.partition("/")[0] for shape in shapes} <= {"robot", "target", "points", *shown.groups}
    for shape in shapes:
        assert all(np.isfinite(value).all() for value in shape.look.values() if isinstance(value, np.ndarray))
    first, same = shown.at_pose(0), shown.at(shown.dataset.poses.q[0])
    np.testing.assert_allclose(same.flange, first.flange, atol=1e-9)
    np.testing.assert_allclose(same.joints, first.joints, atol=1e-9)
    if first.camera is not None:
        np.testing.assert_allclose(same.camera, first.camera, atol=1e-9)


def test_a_calibration_of_another_cell_is_refused(saved, tmp_path, capsys):
    folder, _ = saved
    other = "point" if robolaser.load(folder / "data").kind == "pose" else "pose"
    typed = ["simulate", "--robot", "ur5", "--sensor", other, "--poses", "12", "--output", str(tmp_path / "other")]
    assert main([*typed, "--quiet"]) == 0
    assert main(["view", str(tmp_path / "other"), str(folder / "result"), "--no-browser"]) == 1
    assert "of another cell" in capsys.readouterr().err
