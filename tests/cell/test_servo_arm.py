"""Bus servos: those that do not hear, and packets as their makers print them."""

from pathlib import Path

import bench
import numpy as np
import pytest
from emulated_cell import cell_folder

from robolaser.cell.failures import AnswerUnclear
from robolaser.cell.servos import READ_ALL, WRITE_ALL, Feetech, crc16
from robolaser.data.cell_config import load_cell
from robolaser.emulator.emulated_cell import controller_of


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


@pytest.mark.parametrize(
    "packet",
    [
        "FF FF FD 00 01 03 00 01 19 4E",  # ping
        "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15",  # read the present position
        "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0",  # its answer
    ],
)
def test_the_crc_is_that_of_the_e_manual(packet: str) -> None:
    *data, low, high = bytes.fromhex(packet)
    assert crc16(bytes(data)) == low + 256 * high


def test_a_sync_read_is_that_of_the_feetech_manual() -> None:
    assert Feetech().instruction(READ_ALL, bytes.fromhex("38 08 01 02")).hex(" ") == "ff ff fe 06 82 38 08 01 02 36"


def test_an_emulated_servo_answers_what_the_manual_asks(tmp_path: Path) -> None:
    servos = controller_of(load_cell(cell_folder(tmp_path, "feetech")))
    answers = servos.receive(bytes.fromhex("FF FF FE 06 82 38 08 01 02 36"), 0.0)
    assert answers[:14].hex(" ") == "ff ff 01 0a 00 00 08 00 00 00 00 00 00 ec"
    assert answers[14:].hex(" ") == "ff ff 02 0a 00 00 08 00 00 00 00 00 00 eb"
