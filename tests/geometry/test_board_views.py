"""A camera's intrinsics from views of boards, with and without a lens that is known."""

import numpy as np
import pytest

from robolaser.geometry.board_views import BoardView, find_intrinsics
from robolaser.geometry.rigid_motion import apply, exp_so3, pose
from robolaser.model.sensors.camera_projection import project
from robolaser.parameters import as_batch

TRUTH = {
    "fx": 1600.0, "fy": 1590.0, "cx": 640.0, "cy": 520.0, "k1": -0.35, "k2": 0.15, "p1": 2e-3, "p2": -1e-3,
    "k3": 0.0,
}  # fmt: skip


@pytest.mark.parametrize("known", [("k1", "k2"), ("p1", "p2"), ("k1", "k2", "p1", "p2", "k3")])
def test_a_lens_that_is_stated_bends_the_views_that_find_the_rest(known: tuple[str, ...]) -> None:
    rng = np.random.default_rng(0)
    grid = np.stack(np.meshgrid(0.03 * np.arange(8), 0.03 * np.arange(6)), axis=-1).reshape(-1, 2)
    board, views = np.pad(grid, ((0, 0), (0, 1))), []
    for _ in range(12):
        T = pose(exp_so3(rng.uniform(-0.5, 0.5, 3)), np.array([-0.1, -0.07, rng.uniform(0.3, 0.5)]))
        views.append(BoardView(board, project(apply(T, board)[None], as_batch(TRUTH))[0]))
    found = find_intrinsics(views, (1280, 1024), {name: TRUTH[name] for name in known})
    assert {name: found[name] for name in known} == {name: TRUTH[name] for name in known}
    shift = 0.5 if "p1" in known else 10.0  # a decentred lens that is not known moves the principal point
    assert found["fx"] == pytest.approx(TRUTH["fx"], abs=shift)
    assert found["cx"] == pytest.approx(TRUTH["cx"], abs=shift)
