"""Bus servos that do not hear."""

from pathlib import Path

import bench
import numpy as np
import pytest

from robolaser.cell.failures import AnswerUnclear
from robolaser.cell.servos import WRITE_ALL


@pytest.mark.parametrize("kind", ["dynamixel", "feetech"])
def test_a_stop_that_no_servo_heard_is_said(tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    cell = bench.cell(tmp_path, kind)
    rig = bench.bench_for(cell)
    arm = bench.arm_on(rig, cell)
    arm.start_move(rig.motor() + np.array([0.4, 0.2, 0.1, 0.3, -0.2]), 4.0)
    rig.clock.wait(1.0)
    receive, code = rig.controller.receive, 7 if kind == "dynamixel" else 4
    deaf = [True]
    monkeypatch.setattr(
        rig.controller,
        "receive",
        lambda data, now_s: b"" if deaf[0] and data[code] == WRITE_ALL else receive(data, now_s),
    )
    with pytest.raises(AnswerUnclear, match="stop at"):
        arm.stop()
    deaf[0] = False
    arm.stop()
    stands = rig.motor()
    rig.clock.wait(10.0)
    np.testing.assert_allclose(rig.motor(), stands, atol=2e-3)
